// Fragments to colours without the light of fields: shadow rays, direct light, ground and sky; and what share of the
// fields' light will be seen, at which point of which model. The twin is forest/relight.rs of the CPU's renderer.

const BLACK: f32 = 1e-9;
const FRAC_1_PI: f32 = 0.31830987;
const FRAC_1_2_PI: f32 = 0.15915494;
const FRAC_1_4_PI: f32 = 0.07957747;

struct Surface {
    point: vec3<f32>,
    // Of the flat triangle, towards the ray's origin, and interpolated, on its side.
    flat_normal: vec3<f32>,
    normal: vec3<f32>,
    color: vec3<f32>,
    material: u32,
}

// The sky as it is drawn, [y][x]: rows from overhead to below, columns from south by way of west.
@group(3) @binding(0) var dome: texture_2d<f32>;

@compute @workgroup_size(WORKGROUP)
fn shade(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let task = task_of(workgroup.x, local);
    if !task.is_inside {
        return;
    }
    var fragment = fragments[task.ray];
    var line = Line(vec3<f32>(0.0), direction_of(task));
    let is_by_water = HAS_WATER && (fragment.triangle & BY_WATER) != 0u;
    var facet = Facet(vec3<f32>(0.0), 0.0, line);
    if is_by_water {
        facet = facet_along(line.direction);
        line = facet.back;
        fragment.triangle &= ~BY_WATER;
    }
    var seen = seen_along(fragment, line, is_by_water || daylight.has_backdrop != 0u);
    if is_by_water {
        let looking = direction_of(task);
        let body = body_color(line.origin, sky_on_water(fragment)) * (1.0 - facet.share);
        var shine = highlight(2u, facet.normal, daylight.towards_sun, looking);
        if daylight.ripples > 0.0 {
            shine = glint(facet.normal, looking, daylight.towards_sun, daylight.ripples);
        }
        seen.color = seen.color * facet.share + body + sun_on(line.origin, shine);
        seen.share *= facet.share;
    }
    lit[task.ray] = seen;
}

fn seen_along(fragment: Fragment, line: Line, has_sky: bool) -> Lit {
    var seen = Lit(vec3<f32>(0.0), fragment.instance, vec3<f32>(0.0), 0u, vec3<f32>(0.0), 0u);
    if fragment.instance == SKY {
        seen.color = sky_if(has_sky, line.direction);
    } else if fragment.instance == GROUND {
        let point = line.origin + line.direction * fragment.distance_m;
        let cover = cover_at(point);
        seen.color = ground_color(point, fragment.sky) * cover + sky_if(has_sky, line.direction) * (1.0 - cover);
    } else {
        seen = plant(fragment, line.direction);
    }
    return seen;
}

fn plant(fragment: Fragment, direction: vec3<f32>) -> Lit {
    let instance = instances[fragment.instance];
    let looking = into_model(instance, direction);
    let towards = into_model(instance, daylight.towards_sun);
    let hit = surface(fragment, looking);
    var seen = Lit(vec3<f32>(0.0), fragment.instance, vec3<f32>(0.0), 0u, hit.point, 0u);
    let is_leaf = materials[hit.material].kind == CLASS_LEAF;
    if daylight.show == SHOW_INSTANCES {
        let h = hash(instance.number);
        seen.color = vec3<f32>(f32(h & 255u), f32((h >> 8u) & 255u), f32((h >> 16u) & 255u)) / 255.0;
        return seen;
    }
    if daylight.show == SHOW_NORMALS {
        seen.color = hit.normal * 0.5 + vec3<f32>(0.5);
        return seen;
    }
    var direct = vec3<f32>(0.0);
    var side = hit.flat_normal;
    if daylight.units == UNITS_WHITE {
        let cosine = dot(hit.normal, towards);
        if cosine > 0.0 && dot(hit.flat_normal, towards) > 0.0 {
            direct = hit.color * cosine;
            let kind = select(1u, 0u, is_leaf);
            direct += vec3<f32>(highlight(kind, hit.normal, towards, looking));
        }
        // The scale of indirect light lies in what fields are multiplied with.
        seen.share = hit.color * daylight.indirect;
    } else {
        let unit = materials[hit.material].unit;
        let ratio = select(vec3<f32>(1.0), hit.color / max(unit, vec3<f32>(BLACK)), unit > vec3<f32>(BLACK));
        var reflectance = ratio * materials[hit.material].reflectance;
        var transmittance = ratio * materials[hit.material].transmittance;
        let fit = 1.0 / max(reflectance + transmittance, vec3<f32>(1.0));
        reflectance *= fit;
        transmittance *= fit;
        let cosine = dot(hit.flat_normal, towards);
        direct = select(transmittance, reflectance, cosine >= 0.0) * (FRAC_1_PI * abs(cosine));
        side = select(-hit.flat_normal, hit.flat_normal, cosine >= 0.0);
        let offset_m = materials[hit.material].solid_offset_m;
        let received = select(FRAC_1_4_PI, FRAC_1_2_PI, offset_m < 0.0);
        if !is_leaf {
            seen.facing_xy = pack2x16snorm(hit.flat_normal.xy);
            seen.facing_z = pack2x16snorm(vec2<f32>(hit.flat_normal.z, 0.0));
        }
        seen.share = (reflectance + transmittance) * (received * daylight.indirect);
        seen.point_model_m += hit.flat_normal * max(offset_m, 0.0);
    }
    direct *= daylight.sun_color * (daylight.sun_strength * daylight.direct);
    if any(direct != vec3<f32>(0.0)) && !is_shaded(fragment, instance, hit.point, side, towards) {
        seen.color = direct;
    }
    return seen;
}

// Whether anything stands between the sun and a point on one side of a plant's surface.
fn is_shaded(fragment: Fragment, instance: Instance, point: vec3<f32>, side: vec3<f32>, towards: vec3<f32>) -> bool {
    let model = models[instance.species];
    let origin = point + side * model.lift;
    // The plant itself is the likeliest to stand in the way.
    if is_blocked_in_model(model.root, 0u, origin, towards, fragment.triangle) {
        return true;
    }
    return is_blocked(out_of_model(instance, origin), fragment.instance);
}

// Whether the ground or a plant but one blocks a ray to the sun.
fn is_blocked(origin: vec3<f32>, except: u32) -> bool {
    return is_stopped(origin, daylight.towards_sun) || is_hidden_from_sun(origin, except);
}

fn surface(fragment: Fragment, looking: vec3<f32>) -> Surface {
    let triangle = triangles[fragment.triangle];
    let weights = fragment.weights;
    let a = vertices[triangle.a].point;
    let e1 = vertices[triangle.b].point - a;
    let e2 = vertices[triangle.c].point - a;
    let across = cross(e1, e2);
    let size = length(across);
    var flat_normal = select(-looking, across / size, size > 0.0);
    flat_normal = select(flat_normal, -flat_normal, dot(flat_normal, looking) > 0.0);
    let mixed = normal_of(triangle.a, flat_normal) * (1.0 - weights.x - weights.y)
        + normal_of(triangle.b, flat_normal) * weights.x
        + normal_of(triangle.c, flat_normal) * weights.y;
    let mixed_size = length(mixed);
    var normal = select(flat_normal, mixed / mixed_size, mixed_size > 0.0);
    normal = select(normal, -normal, dot(normal, flat_normal) < 0.0);
    let material = triangle.material & 0xffffu;
    let color = color_at(material, uv_at(triangle, weights)) * vertex_color_at(triangle, weights);
    return Surface(a + e1 * weights.x + e2 * weights.y, flat_normal, normal, color, material);
}

fn normal_of(vertex: u32, flat_normal: vec3<f32>) -> vec3<f32> {
    let normal = vertices[vertex].normal;
    return select(normal, flat_normal, all(normal == vec3<f32>(0.0)));
}

// Linear colour of the vertices.
fn vertex_color_at(triangle: Triangle, weights: vec2<f32>) -> vec3<f32> {
    let first = materials[triangle.material & 0xffffu].colors;
    if first == NONE {
        return vec3<f32>(1.0);
    }
    return vertex_color(first + 3u * triangle.a) * (1.0 - weights.x - weights.y)
        + vertex_color(first + 3u * triangle.b) * weights.x
        + vertex_color(first + 3u * triangle.c) * weights.y;
}

fn vertex_color(word: u32) -> vec3<f32> {
    return vec3<f32>(bitcast<f32>(words[word]), bitcast<f32>(words[word + 1u]), bitcast<f32>(words[word + 2u]));
}

// Linear texture colour x base colour.
fn color_at(material: u32, uv: vec3<f32>) -> vec3<f32> {
    let tint = materials[material].tint;
    let image = materials[material].image;
    if image == NONE {
        return tint;
    }
    let size = materials[material].image_size;
    let wrap = materials[material].wrap;
    let at = vec2<f32>(dot(materials[material].image_u, uv), dot(materials[material].image_v, uv));
    let is_nearest = (wrap & NEAREST) != 0u;
    let low = floor(select(at, at + 0.5, is_nearest));
    let part = select(at - low, vec2<f32>(0.0), is_nearest);
    let x = vec2<u32>(wrapped(low.x, size & 0xffffu, wrap & 3u), wrapped(low.x + 1.0, size & 0xffffu, wrap & 3u));
    let y = vec2<u32>(wrapped(low.y, size >> 16u, (wrap >> 2u) & 3u), wrapped(low.y + 1.0, size >> 16u, (wrap >> 2u) & 3u));
    let row = image + y * (size & 0xffffu);
    let top = texel(row.x + x.x) * (1.0 - part.x) + texel(row.x + x.y) * part.x;
    let bottom = texel(row.y + x.x) * (1.0 - part.x) + texel(row.y + x.y) * part.x;
    return tint * (top * (1.0 - part.y) + bottom * part.y);
}

// Linear colour of a word of an image. The table lies in front of all images.
fn texel(word: u32) -> vec3<f32> {
    let bytes = (vec3<u32>(words[word]) >> vec3<u32>(0u, 8u, 16u)) & vec3<u32>(255u);
    return vec3<f32>(bitcast<f32>(words[bytes.x]), bitcast<f32>(words[bytes.y]), bitcast<f32>(words[bytes.z]));
}

fn ground_color(point: vec3<f32>, sky: f32) -> vec3<f32> {
    let cosine = dot(ground_normal(point), daylight.towards_sun);
    let origin = point + vec3<f32>(0.0, view.ground_lift, 0.0);
    return daylight.ground_color * (sun_on(origin, cosine) + sky_on(sky));
}

// What comes out of the water at a point of it.
fn body_color(point: vec3<f32>, sky: f32) -> vec3<f32> {
    let cosine = daylight.towards_sun.y;
    let sun = sun_on(point, cosine) * (1.0 - reflectance(cosine));
    return daylight.water_color * (sun + sky_on(sky) * INTO_FROM_SKY);
}

// What a white ground sends out at a point because of the sun, by the cosine of its angle to the ground's normal.
fn sun_on(origin: vec3<f32>, cosine: f32) -> vec3<f32> {
    if daylight.direct > 0.0 && cosine > 0.0 && daylight.white_in_sun > 0.0 {
        if !is_blocked(origin, NONE) {
            return daylight.sun_color * (cosine * daylight.white_in_sun);
        }
    }
    return vec3<f32>(0.0);
}

// What it sends out because of the sky, of which it sees a share.
fn sky_on(share: f32) -> vec3<f32> {
    return select(vec3<f32>(0.0), daylight.white_under_sky * share, daylight.indirect > 0.0);
}

// How much of the ground is left of the haze.
fn cover_at(point: vec3<f32>) -> f32 {
    let inward = clamp(1.0 - length(point.xz - daylight.center.xz) / daylight.haze_m, 0.0, 1.0);
    return min(inward * inward * (3.0 - 2.0 * inward), 1.0);
}

fn sky_if(has_sky: bool, direction: vec3<f32>) -> vec3<f32> {
    if !has_sky {
        return vec3<f32>(0.0);
    }
    return sky_color(direction);
}

fn sky_color(direction: vec3<f32>) -> vec3<f32> {
    if daylight.has_dome != 0u {
        return dome_color(direction);
    }
    return mix(daylight.horizon, daylight.zenith, sqrt(clamp(direction.y, 0.0, 1.0)));
}

// Between the pixels of the dome.
fn dome_color(direction: vec3<f32>) -> vec3<f32> {
    let size = vec2<f32>(textureDimensions(dome));
    // The quotient of 0 and 0 has no angle.
    let turn = atan2(-direction.x, select(direction.z, 1e-20, all(direction.xz == vec2<f32>(0.0)))) * FRAC_1_2_PI;
    let fall = acos(clamp(direction.y, -1.0, 1.0)) * FRAC_1_PI;
    let at = vec2<f32>(fract(turn), fall) * size - vec2<f32>(0.5);
    let y = clamp(at.y, 0.0, size.y - 1.0);
    let low = vec2<i32>(vec2<f32>(floor(at.x), floor(y)));
    let part = vec2<f32>(at.x - floor(at.x), y - floor(y));
    let last = vec2<i32>(size) - vec2<i32>(1);
    let left = select(low.x, last.x, low.x < 0);
    let right = select(left + 1, 0, left == last.x);
    let below = min(low.y + 1, last.y);
    let top = dome_row(low.y, left, right, part.x);
    return mix(top, dome_row(below, left, right, part.x), part.y);
}

fn dome_row(y: i32, left: i32, right: i32, part: f32) -> vec3<f32> {
    return mix(textureLoad(dome, vec2<i32>(left, y), 0).xyz, textureLoad(dome, vec2<i32>(right, y), 0).xyz, part);
}

// Highlight of leaves (0), wood (1) or water (2), as render/src/highlight.rs has it.
fn highlight(kind: u32, normal: vec3<f32>, towards: vec3<f32>, looking: vec3<f32>) -> f32 {
    if daylight.highlights[kind] == 0.0 {
        return 0.0;
    }
    let mirrored_sun = normal * (2.0 * dot(normal, towards)) - towards;
    return daylight.highlights[kind] * pow(max(dot(mirrored_sun, -looking), 0.0), daylight.exponents[kind]);
}
