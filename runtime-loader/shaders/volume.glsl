#version 450 core
// Made from src/light/volume/volume.wgsl by naga; FLB_WRITE_SHADERS=1 cargo test -p flb-runtime
#extension GL_ARB_shader_storage_buffer_object : require
struct FlbCells {
    uvec2 rows;
    uvec2 yaws;
    float second_row;
    float second_yaw;
};
const uint FLB_VOLUME_LATTICE = 1u;
const uint FLB_VOLUME_MIDDLE = 2u;
const uint FLB_VOLUME_SITES_PER_M = 5u;
const uint FLB_VOLUME_MAP = 6u;
const uint FLB_VOLUME_RANGES = 7u;
const uint FLB_VOLUME_CODES = 8u;
const uint FLB_VOLUME_COARSE = 9u;
const uint FLB_VOLUME_COARSE_EDGE = 10u;
const uint FLB_VOLUME_LEAST = 11u;
const uint FLB_VOLUME_NO_BLOCK = 4294967295u;
const float FLB_VOLUME_COARSE_SITES = 16.0;
const uint FLB_FOREST_PLANTS = 1u;
const uint FLB_FOREST_MAX_PLANTS = 2u;
const uint FLB_SPECIES_FACTOR = 1u;
const uint FLB_SPECIES_REST = 3u;
const uint FLB_SPECIES_STEP_DEG = 6u;
const uint FLB_SPECIES_SUNS = 8u;
const uint FLB_SPECIES_VOLUMES = 24u;
const uint FLB_SUN = 8u;
const uint FLB_SUN_AZIMUTH = 3u;
const uint FLB_SUN_ELEVATION = 4u;
const uint FLB_SUN_OWN_ROW = 5u;
const uint FLB_SUN_TOP_ROW = 6u;
const uint FLB_SUN_STRIDE = 7u;
const uint FLB_PLANT = 4u;
const uint FLB_PLANT_TILTED = 2147483648u;

layout(std430, binding = 0) readonly buffer type_2_block_0Fragment { uint _group_0_binding_0_fs[]; };

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 0) out vec4 _fs2p_location0;

vec3 flb_volume_floats(uint at) {
    uint _e3 = _group_0_binding_0_fs[at];
    uint _e8 = _group_0_binding_0_fs[(at + 1u)];
    uint _e13 = _group_0_binding_0_fs[(at + 2u)];
    uvec3 words = uvec3(_e3, _e8, _e13);
    return uintBitsToFloat(words);
}

uint flb_volume_spread(uint coordinate) {
    uint v = 0u;
    v = ((coordinate | (coordinate << 16u)) & 50331903u);
    uint _e7 = v;
    uint _e8 = v;
    v = ((_e7 | (_e8 << 8u)) & 50393103u);
    uint _e14 = v;
    uint _e15 = v;
    v = ((_e14 | (_e15 << 4u)) & 51130563u);
    uint _e21 = v;
    uint _e22 = v;
    return ((_e21 | (_e22 << 2u)) & 153391689u);
}

uint flb_volume_rank(uint map, uvec3 block) {
    uint _e3 = flb_volume_spread(block.x);
    uint _e5 = flb_volume_spread(block.y);
    uint _e10 = flb_volume_spread(block.z);
    uint code = ((_e3 | (_e5 << 1u)) | (_e10 << 2u));
    uint at_1 = (map + (2u * (code >> 5u)));
    uint bits = _group_0_binding_0_fs[at_1];
    uint bit = (1u << (code & 31u));
    if (((bits & bit) == 0u)) {
        return FLB_VOLUME_NO_BLOCK;
    }
    uint _e34 = _group_0_binding_0_fs[(at_1 + 1u)];
    return (_e34 + uint(bitCount((bits & (bit - 1u)))));
}

vec3 flb_volume_coarse(uint volume, uvec3 texel) {
    vec3 light = vec3(0.0);
    uint corner = 0u;
    uint _e6 = _group_0_binding_0_fs[(volume + FLB_VOLUME_COARSE)];
    uint first = (volume + _e6);
    uint edge = _group_0_binding_0_fs[(volume + FLB_VOLUME_COARSE_EDGE)];
    vec3 place = (((vec3(texel) + vec3(0.5)) / vec3(16.0)) - vec3(0.5));
    vec3 inside = clamp(place, vec3(0.0), vec3((float(edge) - 1.0)));
    uvec3 low = uvec3(inside);
    vec3 part_1 = (inside - vec3(low));
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e80 = corner;
            corner = (_e80 + 1u);
        }
        loop_init = false;
        uint _e38 = corner;
        if ((_e38 < 8u)) {
        } else {
            break;
        }
        {
            uint _e41 = corner;
            uvec3 upper = ((uvec3(_e41) >> uvec3(0u, 1u, 2u)) & uvec3(1u));
            uvec3 at_2 = min((low + upper), uvec3((edge - 1u)));
            vec3 weights = mix((vec3(1.0) - part_1), part_1, vec3(upper));
            vec3 _e71 = flb_volume_floats((first + (3u * ((((at_2.z * edge) + at_2.y) * edge) + at_2.x))));
            vec3 _e72 = light;
            light = (_e72 + (((weights.x * weights.y) * weights.z) * _e71));
        }
    }
    vec3 _e83 = light;
    return _e83;
}

vec3 flb_volume(uint volume_1, vec3 point_m_1) {
    uvec3 block_1 = uvec3(0u);
    uint rank = 0u;
    vec3 light_1 = vec3(0.0);
    uint corner_1 = 0u;
    uint lattice = _group_0_binding_0_fs[(volume_1 + FLB_VOLUME_LATTICE)];
    uint _e11 = _group_0_binding_0_fs[(volume_1 + FLB_VOLUME_SITES_PER_M)];
    float sites_per_m = uintBitsToFloat(_e11);
    vec3 _e15 = flb_volume_floats((volume_1 + FLB_VOLUME_MIDDLE));
    vec3 from_middle = ((point_m_1 - _e15) * sites_per_m);
    float last = (float(lattice) - 1.0);
    vec3 place_1 = clamp((from_middle + vec3((0.5 * last))), vec3(0.0), vec3(last));
    uvec3 texel_1 = min(uvec3(place_1), uvec3((lattice - 2u)));
    vec3 part_2 = (place_1 - vec3(texel_1));
    uint _e40 = _group_0_binding_0_fs[(volume_1 + FLB_VOLUME_MAP)];
    uint map_1 = (volume_1 + _e40);
    uint _e46 = _group_0_binding_0_fs[(volume_1 + FLB_VOLUME_RANGES)];
    uint ranges = (volume_1 + _e46);
    uint _e52 = _group_0_binding_0_fs[(volume_1 + FLB_VOLUME_CODES)];
    uint codes = (volume_1 + _e52);
    block_1 = (texel_1 >> uvec3(2u));
    uvec3 _e58 = block_1;
    uint _e59 = flb_volume_rank(map_1, _e58);
    rank = _e59;
    bool loop_init_1 = true;
    while(true) {
        if (!loop_init_1) {
            uint _e148 = corner_1;
            corner_1 = (_e148 + 1u);
        }
        loop_init_1 = false;
        uint _e66 = corner_1;
        if ((_e66 < 8u)) {
        } else {
            break;
        }
        {
            uint _e69 = corner_1;
            uvec3 upper_1 = ((uvec3(_e69) >> uvec3(0u, 1u, 2u)) & uvec3(1u));
            uvec3 at_3 = (texel_1 + upper_1);
            vec3 weights_1 = mix((vec3(1.0) - part_2), part_2, vec3(upper_1));
            float weight = ((weights_1.x * weights_1.y) * weights_1.z);
            uvec3 its_block = (at_3 >> uvec3(2u));
            uvec3 _e93 = block_1;
            if (any(notEqual(its_block, _e93))) {
                block_1 = its_block;
                uvec3 _e96 = block_1;
                uint _e97 = flb_volume_rank(map_1, _e96);
                rank = _e97;
            }
            uint _e98 = rank;
            if ((_e98 == FLB_VOLUME_NO_BLOCK)) {
                vec3 _e101 = light_1;
                vec3 _e102 = flb_volume_coarse(volume_1, at_3);
                light_1 = (_e101 + (weight * _e102));
            } else {
                uvec3 inside_1 = (at_3 & uvec3(3u));
                uint _e110 = rank;
                uint code_1 = _group_0_binding_0_fs[(((codes + (64u * _e110)) + (((inside_1.z * 4u) + inside_1.y) * 4u)) + inside_1.x)];
                vec3 channels = vec3(((uvec3(code_1) >> uvec3(0u, 8u, 16u)) & uvec3(255u)));
                uint _e136 = rank;
                uint range = (ranges + (6u * _e136));
                vec3 _e139 = light_1;
                vec3 _e140 = flb_volume_floats(range);
                vec3 _e143 = flb_volume_floats((range + 3u));
                light_1 = (_e139 + (weight * (_e140 + (_e143 * channels))));
            }
        }
    }
    uint _e155 = _group_0_binding_0_fs[(volume_1 + FLB_VOLUME_LEAST)];
    float least = uintBitsToFloat(_e155);
    vec3 _e157 = light_1;
    return max(_e157, vec3(least));
}

float flb_share(float share) {
    return ((share > 0.999) ? 1.0 : ((share >= 0.001) ? share : 0.0));
}

FlbCells flb_cells(uint record, uint species, uint sun) {
    float turn = 0.0;
    uvec2 rows = uvec2(0u);
    float second_row = 0.0;
    float azimuth_deg = 0.0;
    uint yaws = _group_0_binding_0_fs[species];
    uint own = _group_0_binding_0_fs[(sun + FLB_SUN_OWN_ROW)];
    uint stride = _group_0_binding_0_fs[(sun + FLB_SUN_STRIDE)];
    if ((stride >= yaws)) {
        return FlbCells(uvec2(own), uvec2(0u), 0.0, 0.0);
    }
    uint _e27 = _group_0_binding_0_fs[(record + 1u)];
    turn = uintBitsToFloat(_e27);
    rows = uvec2(own);
    uint _e36 = _group_0_binding_0_fs[record];
    if ((_e36 >= FLB_PLANT_TILTED)) {
        vec3 _e41 = flb_volume_floats((record + 1u));
        float w = sqrt(max(0.0, (1.0 - dot(_e41, _e41))));
        vec3 _e48 = flb_volume_floats(sun);
        vec3 once = cross(_e41, _e48);
        vec3 seen = (_e48 + (2.0 * (cross(_e41, once) - (w * once))));
        float across = length(seen.xz);
        if ((across > 0.0)) {
            azimuth_deg = degrees(atan(seen.x, -(seen.z)));
        }
        float elevation_deg = degrees(atan(seen.y, max(across, 1e-9)));
        uint _e76 = _group_0_binding_0_fs[(sun + FLB_SUN_AZIMUTH)];
        float sun_azimuth_deg = uintBitsToFloat(_e76);
        float _e78 = azimuth_deg;
        turn = ((((sun_azimuth_deg - _e78) / 360.0) + 2.0) * float(yaws));
        float _e86 = turn;
        float _e87 = turn;
        turn = (_e86 - (floor((_e87 / float(yaws))) * float(yaws)));
        uint _e98 = _group_0_binding_0_fs[(sun + FLB_SUN_ELEVATION)];
        float sun_deg = uintBitsToFloat(_e98);
        uint _e104 = _group_0_binding_0_fs[(species + FLB_SPECIES_STEP_DEG)];
        float step_deg = uintBitsToFloat(_e104);
        float wide = float(stride);
        float low_1 = (float(own) + (floor(((elevation_deg - sun_deg) / (step_deg * wide))) * wide));
        uint _e122 = _group_0_binding_0_fs[(sun + FLB_SUN_TOP_ROW)];
        vec2 between = clamp(vec2(low_1, (low_1 + wide)), vec2(0.0), vec2(float(_e122)));
        vec2 heights_deg = clamp((vec2(sun_deg) + ((between - vec2(float(own))) * step_deg)), vec2(-90.0), vec2(90.0));
        rows = uvec2(between);
        float _e146 = flb_share(((elevation_deg - heights_deg.x) / max((heights_deg.y - heights_deg.x), 0.001)));
        second_row = _e146;
    }
    float _e147 = turn;
    uint first_1 = ((min(uint(_e147), (yaws - 1u)) / stride) * stride);
    uint span = min(stride, (yaws - first_1));
    float _e156 = turn;
    float _e161 = flb_share(((_e156 - float(first_1)) / float(span)));
    uvec2 _e162 = rows;
    float _e166 = second_row;
    return FlbCells(_e162, uvec2(first_1, ((first_1 + span) % yaws)), _e166, _e161);
}

vec3 flb_light(uint forest, uint plant, vec3 point_m_2) {
    vec3 light_2 = vec3(0.0);
    uint age = 0u;
    uint part = 0u;
    uint _e7 = _group_0_binding_0_fs[(forest + FLB_FOREST_MAX_PLANTS)];
    if ((plant >= _e7)) {
        return vec3(0.0);
    }
    uint _e15 = _group_0_binding_0_fs[(forest + FLB_FOREST_PLANTS)];
    uint record_1 = ((forest + _e15) + (FLB_PLANT * plant));
    uint _e22 = _group_0_binding_0_fs[record_1];
    if ((_e22 == 0u)) {
        return vec3(0.0);
    }
    uint _e29 = _group_0_binding_0_fs[record_1];
    uint species_1 = (forest + (_e29 & 2147483647u));
    uint yaws_1 = _group_0_binding_0_fs[species_1];
    vec3 _e38 = flb_volume_floats((species_1 + FLB_SPECIES_REST));
    light_2 = _e38;
    bool loop_init_2 = true;
    while(true) {
        if (!loop_init_2) {
            uint _e126 = age;
            age = (_e126 + 1u);
        }
        loop_init_2 = false;
        uint _e42 = age;
        if ((_e42 < 2u)) {
        } else {
            break;
        }
        {
            uint _e48 = age;
            uint _e51 = _group_0_binding_0_fs[((species_1 + FLB_SPECIES_FACTOR) + _e48)];
            float factor = uintBitsToFloat(_e51);
            if ((factor == 0.0)) {
                continue;
            }
            uint _e58 = age;
            FlbCells _e61 = flb_cells(record_1, species_1, ((species_1 + FLB_SPECIES_SUNS) + (FLB_SUN * _e58)));
            part = 0u;
            bool loop_init_3 = true;
            while(true) {
                if (!loop_init_3) {
                    uint _e123 = part;
                    part = (_e123 + 1u);
                }
                loop_init_3 = false;
                uint _e64 = part;
                if ((_e64 < 4u)) {
                } else {
                    break;
                }
                {
                    uint _e67 = part;
                    uint _e72 = part;
                    bvec2 is_second = bvec2(((_e67 & 1u) == 1u), (_e72 >= 2u));
                    float of_yaw = (is_second.x ? _e61.second_yaw : (1.0 - _e61.second_yaw));
                    float of_row = (is_second.y ? _e61.second_row : (1.0 - _e61.second_row));
                    float share_1 = ((factor * of_yaw) * of_row);
                    if ((share_1 == 0.0)) {
                        continue;
                    }
                    uint row = (is_second.y ? _e61.rows.y : _e61.rows.x);
                    uint cell = ((row * yaws_1) + (is_second.x ? _e61.yaws.y : _e61.yaws.x));
                    uint _e112 = age;
                    uint volume_2 = _group_0_binding_0_fs[(((species_1 + FLB_SPECIES_VOLUMES) + (2u * cell)) + _e112)];
                    if ((volume_2 != 0u)) {
                        vec3 _e118 = light_2;
                        vec3 _e120 = flb_volume((forest + volume_2), point_m_2);
                        light_2 = (_e118 + (share_1 * _e120));
                    }
                }
            }
        }
    }
    vec3 _e129 = light_2;
    return _e129;
}

void main() {
    vec3 point_m = _vs2fs_location0;
    vec3 _e3 = flb_light(0u, 0u, point_m);
    _fs2p_location0 = vec4(_e3, 1.0);
    return;
}

