// Made from src/light/volume/volume.wgsl by naga; FLB_WRITE_SHADERS=1 cargo test -p flb-runtime
struct FlbCells {
    uint2 rows;
    uint2 yaws;
    float second_row;
    float second_yaw;
};

static const uint FLB_VOLUME_LATTICE = 1u;
static const uint FLB_VOLUME_MIDDLE = 2u;
static const uint FLB_VOLUME_SITES_PER_M = 5u;
static const uint FLB_VOLUME_MAP = 6u;
static const uint FLB_VOLUME_RANGES = 7u;
static const uint FLB_VOLUME_CODES = 8u;
static const uint FLB_VOLUME_COARSE = 9u;
static const uint FLB_VOLUME_COARSE_EDGE = 10u;
static const uint FLB_VOLUME_LEAST = 11u;
static const uint FLB_VOLUME_NO_BLOCK = 4294967295u;
static const float FLB_VOLUME_COARSE_SITES = 16.0;
static const uint FLB_FOREST_PLANTS = 1u;
static const uint FLB_FOREST_MAX_PLANTS = 2u;
static const uint FLB_SPECIES_FACTOR = 1u;
static const uint FLB_SPECIES_REST = 3u;
static const uint FLB_SPECIES_STEP_DEG = 6u;
static const uint FLB_SPECIES_SUNS = 8u;
static const uint FLB_SPECIES_VOLUMES = 24u;
static const uint FLB_SUN = 8u;
static const uint FLB_SUN_AZIMUTH = 3u;
static const uint FLB_SUN_ELEVATION = 4u;
static const uint FLB_SUN_OWN_ROW = 5u;
static const uint FLB_SUN_TOP_ROW = 6u;
static const uint FLB_SUN_STRIDE = 7u;
static const uint FLB_PLANT = 4u;
static const uint FLB_PLANT_TILTED = 2147483648u;

ByteAddressBuffer flb_volumes : register(t0);

float3 flb_volume_floats(uint at)
{
    uint _e3 = asuint(flb_volumes.Load(at*4));
    uint _e8 = asuint(flb_volumes.Load((at + 1u)*4));
    uint _e13 = asuint(flb_volumes.Load((at + 2u)*4));
    uint3 words = uint3(_e3, _e8, _e13);
    return asfloat(words);
}

uint flb_volume_spread(uint coordinate)
{
    uint v = (uint)0;

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

uint flb_volume_rank(uint map, uint3 block)
{
    const uint _e3 = flb_volume_spread(block.x);
    const uint _e5 = flb_volume_spread(block.y);
    const uint _e10 = flb_volume_spread(block.z);
    uint code = ((_e3 | (_e5 << 1u)) | (_e10 << 2u));
    uint at_1 = (map + (2u * (code >> 5u)));
    uint bits = asuint(flb_volumes.Load(at_1*4));
    uint bit = (1u << (code & 31u));
    if (((bits & bit) == 0u)) {
        return FLB_VOLUME_NO_BLOCK;
    }
    uint _e34 = asuint(flb_volumes.Load((at_1 + 1u)*4));
    return (_e34 + countbits((bits & (bit - 1u))));
}

uint3 naga_f2u32(float3 value) {
    return uint3(clamp(value, 0.0, 4294967000.0));
}

float3 flb_volume_coarse(uint volume, uint3 texel)
{
    float3 light = (0.0).xxx;
    uint corner = 0u;

    uint _e6 = asuint(flb_volumes.Load((volume + FLB_VOLUME_COARSE)*4));
    uint first = (volume + _e6);
    uint edge = asuint(flb_volumes.Load((volume + FLB_VOLUME_COARSE_EDGE)*4));
    float3 place = (((float3(texel) + (0.5).xxx) / (16.0).xxx) - (0.5).xxx);
    float3 inside = clamp(place, (0.0).xxx, ((float(edge) - 1.0)).xxx);
    uint3 low = naga_f2u32(inside);
    float3 part_1 = (inside - float3(low));
    uint2 loop_bound = uint2(4294967295u, 4294967295u);
    bool loop_init = true;
    while(true) {
        if (all(loop_bound == uint2(0u, 0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
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
            uint3 upper = (((_e41).xxx >> uint3(0u, 1u, 2u)) & (1u).xxx);
            uint3 at_2 = min((low + upper), ((edge - 1u)).xxx);
            float3 weights = lerp(((1.0).xxx - part_1), part_1, float3(upper));
            const float3 _e71 = flb_volume_floats((first + (3u * ((((at_2.z * edge) + at_2.y) * edge) + at_2.x))));
            float3 _e72 = light;
            light = (_e72 + (((weights.x * weights.y) * weights.z) * _e71));
        }
    }
    float3 _e83 = light;
    return _e83;
}

float3 flb_volume(uint volume_1, float3 point_m)
{
    uint3 block_1 = (uint3)0;
    uint rank = (uint)0;
    float3 light_1 = (0.0).xxx;
    uint corner_1 = 0u;

    uint lattice = asuint(flb_volumes.Load((volume_1 + FLB_VOLUME_LATTICE)*4));
    uint _e11 = asuint(flb_volumes.Load((volume_1 + FLB_VOLUME_SITES_PER_M)*4));
    float sites_per_m = asfloat(_e11);
    const float3 _e15 = flb_volume_floats((volume_1 + FLB_VOLUME_MIDDLE));
    float3 from_middle = ((point_m - _e15) * sites_per_m);
    float last = (float(lattice) - 1.0);
    float3 place_1 = clamp((from_middle + ((0.5 * last)).xxx), (0.0).xxx, (last).xxx);
    uint3 texel_1 = min(naga_f2u32(place_1), ((lattice - 2u)).xxx);
    float3 part_2 = (place_1 - float3(texel_1));
    uint _e40 = asuint(flb_volumes.Load((volume_1 + FLB_VOLUME_MAP)*4));
    uint map_1 = (volume_1 + _e40);
    uint _e46 = asuint(flb_volumes.Load((volume_1 + FLB_VOLUME_RANGES)*4));
    uint ranges = (volume_1 + _e46);
    uint _e52 = asuint(flb_volumes.Load((volume_1 + FLB_VOLUME_CODES)*4));
    uint codes = (volume_1 + _e52);
    block_1 = (texel_1 >> (2u).xxx);
    uint3 _e58 = block_1;
    const uint _e59 = flb_volume_rank(map_1, _e58);
    rank = _e59;
    uint2 loop_bound_1 = uint2(4294967295u, 4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (all(loop_bound_1 == uint2(0u, 0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
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
            uint3 upper_1 = (((_e69).xxx >> uint3(0u, 1u, 2u)) & (1u).xxx);
            uint3 at_3 = (texel_1 + upper_1);
            float3 weights_1 = lerp(((1.0).xxx - part_2), part_2, float3(upper_1));
            float weight = ((weights_1.x * weights_1.y) * weights_1.z);
            uint3 its_block = (at_3 >> (2u).xxx);
            uint3 _e93 = block_1;
            if (any((its_block != _e93))) {
                block_1 = its_block;
                uint3 _e96 = block_1;
                const uint _e97 = flb_volume_rank(map_1, _e96);
                rank = _e97;
            }
            uint _e98 = rank;
            if ((_e98 == FLB_VOLUME_NO_BLOCK)) {
                float3 _e101 = light_1;
                const float3 _e102 = flb_volume_coarse(volume_1, at_3);
                light_1 = (_e101 + (weight * _e102));
            } else {
                uint3 inside_1 = (at_3 & (3u).xxx);
                uint _e110 = rank;
                uint code_1 = asuint(flb_volumes.Load((((codes + (64u * _e110)) + (((inside_1.z * 4u) + inside_1.y) * 4u)) + inside_1.x)*4));
                float3 channels = float3((((code_1).xxx >> uint3(0u, 8u, 16u)) & (255u).xxx));
                uint _e136 = rank;
                uint range = (ranges + (6u * _e136));
                float3 _e139 = light_1;
                const float3 _e140 = flb_volume_floats(range);
                const float3 _e143 = flb_volume_floats((range + 3u));
                light_1 = (_e139 + (weight * (_e140 + (_e143 * channels))));
            }
        }
    }
    uint _e155 = asuint(flb_volumes.Load((volume_1 + FLB_VOLUME_LEAST)*4));
    float least = asfloat(_e155);
    float3 _e157 = light_1;
    return max(_e157, (least).xxx);
}

float flb_share(float share)
{
    return ((share > 0.999) ? 1.0 : ((share >= 0.001) ? share : 0.0));
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / (rhs == 0u ? 1u : rhs);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % (rhs == 0u ? 1u : rhs);
}

FlbCells ConstructFlbCells(uint2 arg0, uint2 arg1, float arg2, float arg3) {
    FlbCells ret = (FlbCells)0;
    ret.rows = arg0;
    ret.yaws = arg1;
    ret.second_row = arg2;
    ret.second_yaw = arg3;
    return ret;
}

uint2 naga_f2u32(float2 value) {
    return uint2(clamp(value, 0.0, 4294967000.0));
}

uint naga_f2u32(float value) {
    return uint(clamp(value, 0.0, 4294967000.0));
}

FlbCells flb_cells(uint record, uint species, uint sun)
{
    float turn = (float)0;
    uint2 rows = (uint2)0;
    float second_row = 0.0;
    float azimuth_deg = 0.0;

    uint yaws = asuint(flb_volumes.Load(species*4));
    uint own = asuint(flb_volumes.Load((sun + FLB_SUN_OWN_ROW)*4));
    uint stride = asuint(flb_volumes.Load((sun + FLB_SUN_STRIDE)*4));
    if ((stride >= yaws)) {
        const FlbCells flbcells = ConstructFlbCells((own).xx, (0u).xx, 0.0, 0.0);
        return flbcells;
    }
    uint _e27 = asuint(flb_volumes.Load((record + 1u)*4));
    turn = asfloat(_e27);
    rows = (own).xx;
    uint _e36 = asuint(flb_volumes.Load(record*4));
    if ((_e36 >= FLB_PLANT_TILTED)) {
        const float3 _e41 = flb_volume_floats((record + 1u));
        float w = sqrt(max(0.0, (1.0 - dot(_e41, _e41))));
        const float3 _e48 = flb_volume_floats(sun);
        float3 once = cross(_e41, _e48);
        float3 seen = (_e48 + (2.0 * (cross(_e41, once) - (w * once))));
        float across = length(seen.xz);
        if ((across > 0.0)) {
            azimuth_deg = degrees(atan2(seen.x, -(seen.z)));
        }
        float elevation_deg = degrees(atan2(seen.y, max(across, 1e-9)));
        uint _e76 = asuint(flb_volumes.Load((sun + FLB_SUN_AZIMUTH)*4));
        float sun_azimuth_deg = asfloat(_e76);
        float _e78 = azimuth_deg;
        turn = ((((sun_azimuth_deg - _e78) / 360.0) + 2.0) * float(yaws));
        float _e86 = turn;
        float _e87 = turn;
        turn = (_e86 - (floor((_e87 / float(yaws))) * float(yaws)));
        uint _e98 = asuint(flb_volumes.Load((sun + FLB_SUN_ELEVATION)*4));
        float sun_deg = asfloat(_e98);
        uint _e104 = asuint(flb_volumes.Load((species + FLB_SPECIES_STEP_DEG)*4));
        float step_deg = asfloat(_e104);
        float wide = float(stride);
        float low_1 = (float(own) + (floor(((elevation_deg - sun_deg) / (step_deg * wide))) * wide));
        uint _e122 = asuint(flb_volumes.Load((sun + FLB_SUN_TOP_ROW)*4));
        float2 between = clamp(float2(low_1, (low_1 + wide)), (0.0).xx, (float(_e122)).xx);
        float2 heights_deg = clamp(((sun_deg).xx + ((between - (float(own)).xx) * step_deg)), (-90.0).xx, (90.0).xx);
        rows = naga_f2u32(between);
        const float _e146 = flb_share(((elevation_deg - heights_deg.x) / max((heights_deg.y - heights_deg.x), 0.001)));
        second_row = _e146;
    }
    float _e147 = turn;
    uint first_1 = (naga_div(min(naga_f2u32(_e147), (yaws - 1u)), stride) * stride);
    uint span = min(stride, (yaws - first_1));
    float _e156 = turn;
    const float _e161 = flb_share(((_e156 - float(first_1)) / float(span)));
    uint2 _e162 = rows;
    float _e166 = second_row;
    const FlbCells flbcells_1 = ConstructFlbCells(_e162, uint2(first_1, naga_mod((first_1 + span), yaws)), _e166, _e161);
    return flbcells_1;
}

float3 flb_light(uint forest, uint plant, float3 point_m_1)
{
    float3 light_2 = (float3)0;
    uint age = 0u;
    uint part = (uint)0;

    uint _e7 = asuint(flb_volumes.Load((forest + FLB_FOREST_MAX_PLANTS)*4));
    if ((plant >= _e7)) {
        return (0.0).xxx;
    }
    uint _e15 = asuint(flb_volumes.Load((forest + FLB_FOREST_PLANTS)*4));
    uint record_1 = ((forest + _e15) + (FLB_PLANT * plant));
    uint _e22 = asuint(flb_volumes.Load(record_1*4));
    if ((_e22 == 0u)) {
        return (0.0).xxx;
    }
    uint _e29 = asuint(flb_volumes.Load(record_1*4));
    uint species_1 = (forest + (_e29 & 2147483647u));
    uint yaws_1 = asuint(flb_volumes.Load(species_1*4));
    const float3 _e38 = flb_volume_floats((species_1 + FLB_SPECIES_REST));
    light_2 = _e38;
    uint2 loop_bound_2 = uint2(4294967295u, 4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (all(loop_bound_2 == uint2(0u, 0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
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
            uint _e51 = asuint(flb_volumes.Load(((species_1 + FLB_SPECIES_FACTOR) + _e48)*4));
            float factor = asfloat(_e51);
            if ((factor == 0.0)) {
                continue;
            }
            uint _e58 = age;
            const FlbCells _e61 = flb_cells(record_1, species_1, ((species_1 + FLB_SPECIES_SUNS) + (FLB_SUN * _e58)));
            part = 0u;
            uint2 loop_bound_3 = uint2(4294967295u, 4294967295u);
            bool loop_init_3 = true;
            while(true) {
                if (all(loop_bound_3 == uint2(0u, 0u))) { break; }
                loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
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
                    bool2 is_second = bool2(((_e67 & 1u) == 1u), (_e72 >= 2u));
                    float of_yaw = (is_second.x ? _e61.second_yaw : (1.0 - _e61.second_yaw));
                    float of_row = (is_second.y ? _e61.second_row : (1.0 - _e61.second_row));
                    float share_1 = ((factor * of_yaw) * of_row);
                    if ((share_1 == 0.0)) {
                        continue;
                    }
                    uint row = (is_second.y ? _e61.rows.y : _e61.rows.x);
                    uint cell = ((row * yaws_1) + (is_second.x ? _e61.yaws.y : _e61.yaws.x));
                    uint _e112 = age;
                    uint volume_2 = asuint(flb_volumes.Load((((species_1 + FLB_SPECIES_VOLUMES) + (2u * cell)) + _e112)*4));
                    if ((volume_2 != 0u)) {
                        float3 _e118 = light_2;
                        const float3 _e120 = flb_volume((forest + volume_2), point_m_1);
                        light_2 = (_e118 + (share_1 * _e120));
                    }
                }
            }
        }
    }
    float3 _e129 = light_2;
    return _e129;
}

