// Made from src/light/volume/volume.wgsl by naga; FLB_WRITE_SHADERS=1 cargo test -p flb-runtime
// language: metal2.0
#include <metal_stdlib>
#include <simd/simd.h>

using metal::uint;

struct _mslBufferSizes {
    uint size0;
};

typedef uint type_2[1];
struct FlbCells {
    metal::uint2 rows;
    metal::uint2 yaws;
    float second_row;
    float second_yaw;
};
constant uint FLB_VOLUME_LATTICE = 1u;
constant uint FLB_VOLUME_MIDDLE = 2u;
constant uint FLB_VOLUME_SITES_PER_M = 5u;
constant uint FLB_VOLUME_MAP = 6u;
constant uint FLB_VOLUME_RANGES = 7u;
constant uint FLB_VOLUME_CODES = 8u;
constant uint FLB_VOLUME_COARSE = 9u;
constant uint FLB_VOLUME_COARSE_EDGE = 10u;
constant uint FLB_VOLUME_LEAST = 11u;
constant uint FLB_VOLUME_NO_BLOCK = 4294967295u;
constant float FLB_VOLUME_COARSE_SITES = 16.0;
constant uint FLB_FOREST_PLANTS = 1u;
constant uint FLB_FOREST_MAX_PLANTS = 2u;
constant uint FLB_SPECIES_FACTOR = 1u;
constant uint FLB_SPECIES_REST = 3u;
constant uint FLB_SPECIES_STEP_DEG = 6u;
constant uint FLB_SPECIES_SUNS = 8u;
constant uint FLB_SPECIES_VOLUMES = 24u;
constant uint FLB_SUN = 8u;
constant uint FLB_SUN_AZIMUTH = 3u;
constant uint FLB_SUN_ELEVATION = 4u;
constant uint FLB_SUN_OWN_ROW = 5u;
constant uint FLB_SUN_TOP_ROW = 6u;
constant uint FLB_SUN_STRIDE = 7u;
constant uint FLB_PLANT = 4u;
constant uint FLB_PLANT_TILTED = 2147483648u;

metal::float3 flb_volume_floats(
    uint at,
    device type_2 const& flb_volumes,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint _e3 = flb_volumes[at];
    uint _e8 = flb_volumes[at + 1u];
    uint _e13 = flb_volumes[at + 2u];
    metal::uint3 words = metal::uint3(_e3, _e8, _e13);
    return as_type<metal::float3>(words);
}

uint flb_volume_spread(
    uint coordinate
) {
    uint v = {};
    v = (coordinate | (coordinate << 16u)) & 50331903u;
    uint _e7 = v;
    uint _e8 = v;
    v = (_e7 | (_e8 << 8u)) & 50393103u;
    uint _e14 = v;
    uint _e15 = v;
    v = (_e14 | (_e15 << 4u)) & 51130563u;
    uint _e21 = v;
    uint _e22 = v;
    return (_e21 | (_e22 << 2u)) & 153391689u;
}

uint flb_volume_rank(
    uint map,
    metal::uint3 block,
    device type_2 const& flb_volumes,
    constant _mslBufferSizes& _buffer_sizes
) {
    uint _e3 = flb_volume_spread(block.x);
    uint _e5 = flb_volume_spread(block.y);
    uint _e10 = flb_volume_spread(block.z);
    uint code = (_e3 | (_e5 << 1u)) | (_e10 << 2u);
    uint at_1 = map + (2u * (code >> 5u));
    uint bits = flb_volumes[at_1];
    uint bit = 1u << (code & 31u);
    if ((bits & bit) == 0u) {
        return FLB_VOLUME_NO_BLOCK;
    }
    uint _e34 = flb_volumes[at_1 + 1u];
    return _e34 + metal::popcount(bits & (bit - 1u));
}

metal::uint3 naga_f2u32(metal::float3 value) {
    return static_cast<metal::uint3>(metal::clamp(value, 0.0, 4294967000.0));
}

metal::float3 flb_volume_coarse(
    uint volume,
    metal::uint3 texel,
    device type_2 const& flb_volumes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float3 light = metal::float3(0.0);
    uint corner = 0u;
    uint _e6 = flb_volumes[volume + FLB_VOLUME_COARSE];
    uint first = volume + _e6;
    uint edge = flb_volumes[volume + FLB_VOLUME_COARSE_EDGE];
    metal::float3 place = ((static_cast<metal::float3>(texel) + metal::float3(0.5)) / metal::float3(16.0)) - metal::float3(0.5);
    metal::float3 inside = metal::clamp(place, metal::float3(0.0), metal::float3(static_cast<float>(edge) - 1.0));
    metal::uint3 low = naga_f2u32(inside);
    metal::float3 part_1 = inside - static_cast<metal::float3>(low);
    uint2 loop_bound = uint2(4294967295u);
    bool loop_init = true;
    while(true) {
        if (metal::all(loop_bound == uint2(0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
        if (!loop_init) {
            uint _e80 = corner;
            corner = _e80 + 1u;
        }
        loop_init = false;
        uint _e38 = corner;
        if (_e38 < 8u) {
        } else {
            break;
        }
        {
            uint _e41 = corner;
            metal::uint3 upper = (metal::uint3(_e41) >> metal::uint3(0u, 1u, 2u)) & metal::uint3(1u);
            metal::uint3 at_2 = metal::min(low + upper, metal::uint3(edge - 1u));
            metal::float3 weights = metal::mix(metal::float3(1.0) - part_1, part_1, static_cast<metal::float3>(upper));
            metal::float3 _e71 = flb_volume_floats(first + (3u * ((((at_2.z * edge) + at_2.y) * edge) + at_2.x)), flb_volumes, _buffer_sizes);
            metal::float3 _e72 = light;
            light = _e72 + (((weights.x * weights.y) * weights.z) * _e71);
        }
    }
    metal::float3 _e83 = light;
    return _e83;
}

metal::float3 flb_volume(
    uint volume_1,
    metal::float3 point_m,
    device type_2 const& flb_volumes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::uint3 block_1 = {};
    uint rank = {};
    metal::float3 light_1 = metal::float3(0.0);
    uint corner_1 = 0u;
    uint lattice = flb_volumes[volume_1 + FLB_VOLUME_LATTICE];
    uint _e11 = flb_volumes[volume_1 + FLB_VOLUME_SITES_PER_M];
    float sites_per_m = as_type<float>(_e11);
    metal::float3 _e15 = flb_volume_floats(volume_1 + FLB_VOLUME_MIDDLE, flb_volumes, _buffer_sizes);
    metal::float3 from_middle = (point_m - _e15) * sites_per_m;
    float last = static_cast<float>(lattice) - 1.0;
    metal::float3 place_1 = metal::clamp(from_middle + metal::float3(0.5 * last), metal::float3(0.0), metal::float3(last));
    metal::uint3 texel_1 = metal::min(naga_f2u32(place_1), metal::uint3(lattice - 2u));
    metal::float3 part_2 = place_1 - static_cast<metal::float3>(texel_1);
    uint _e40 = flb_volumes[volume_1 + FLB_VOLUME_MAP];
    uint map_1 = volume_1 + _e40;
    uint _e46 = flb_volumes[volume_1 + FLB_VOLUME_RANGES];
    uint ranges = volume_1 + _e46;
    uint _e52 = flb_volumes[volume_1 + FLB_VOLUME_CODES];
    uint codes = volume_1 + _e52;
    block_1 = texel_1 >> metal::uint3(2u);
    metal::uint3 _e58 = block_1;
    uint _e59 = flb_volume_rank(map_1, _e58, flb_volumes, _buffer_sizes);
    rank = _e59;
    uint2 loop_bound_1 = uint2(4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (metal::all(loop_bound_1 == uint2(0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e148 = corner_1;
            corner_1 = _e148 + 1u;
        }
        loop_init_1 = false;
        uint _e66 = corner_1;
        if (_e66 < 8u) {
        } else {
            break;
        }
        {
            uint _e69 = corner_1;
            metal::uint3 upper_1 = (metal::uint3(_e69) >> metal::uint3(0u, 1u, 2u)) & metal::uint3(1u);
            metal::uint3 at_3 = texel_1 + upper_1;
            metal::float3 weights_1 = metal::mix(metal::float3(1.0) - part_2, part_2, static_cast<metal::float3>(upper_1));
            float weight = (weights_1.x * weights_1.y) * weights_1.z;
            metal::uint3 its_block = at_3 >> metal::uint3(2u);
            metal::uint3 _e93 = block_1;
            if (metal::any(its_block != _e93)) {
                block_1 = its_block;
                metal::uint3 _e96 = block_1;
                uint _e97 = flb_volume_rank(map_1, _e96, flb_volumes, _buffer_sizes);
                rank = _e97;
            }
            uint _e98 = rank;
            if (_e98 == FLB_VOLUME_NO_BLOCK) {
                metal::float3 _e101 = light_1;
                metal::float3 _e102 = flb_volume_coarse(volume_1, at_3, flb_volumes, _buffer_sizes);
                light_1 = _e101 + (weight * _e102);
            } else {
                metal::uint3 inside_1 = at_3 & metal::uint3(3u);
                uint _e110 = rank;
                uint code_1 = flb_volumes[((codes + (64u * _e110)) + (((inside_1.z * 4u) + inside_1.y) * 4u)) + inside_1.x];
                metal::float3 channels = static_cast<metal::float3>((metal::uint3(code_1) >> metal::uint3(0u, 8u, 16u)) & metal::uint3(255u));
                uint _e136 = rank;
                uint range = ranges + (6u * _e136);
                metal::float3 _e139 = light_1;
                metal::float3 _e140 = flb_volume_floats(range, flb_volumes, _buffer_sizes);
                metal::float3 _e143 = flb_volume_floats(range + 3u, flb_volumes, _buffer_sizes);
                light_1 = _e139 + (weight * (_e140 + (_e143 * channels)));
            }
        }
    }
    uint _e155 = flb_volumes[volume_1 + FLB_VOLUME_LEAST];
    float least = as_type<float>(_e155);
    metal::float3 _e157 = light_1;
    return metal::max(_e157, metal::float3(least));
}

float flb_share(
    float share
) {
    return (share > 0.999) ? 1.0 : ((share >= 0.001) ? share : 0.0);
}

metal::uint2 naga_f2u32(metal::float2 value) {
    return static_cast<metal::uint2>(metal::clamp(value, 0.0, 4294967000.0));
}

uint naga_f2u32(float value) {
    return static_cast<uint>(metal::clamp(value, 0.0, 4294967000.0));
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / metal::select(rhs, 1u, rhs == 0u);
}

uint naga_mod(uint lhs, uint rhs) {
    return lhs % metal::select(rhs, 1u, rhs == 0u);
}

FlbCells flb_cells(
    uint record,
    uint species,
    uint sun,
    device type_2 const& flb_volumes,
    constant _mslBufferSizes& _buffer_sizes
) {
    float turn = {};
    metal::uint2 rows = {};
    float second_row = 0.0;
    float azimuth_deg = 0.0;
    uint yaws = flb_volumes[species];
    uint own = flb_volumes[sun + FLB_SUN_OWN_ROW];
    uint stride = flb_volumes[sun + FLB_SUN_STRIDE];
    if (stride >= yaws) {
        return FlbCells {metal::uint2(own), metal::uint2(0u), 0.0, 0.0};
    }
    uint _e27 = flb_volumes[record + 1u];
    turn = as_type<float>(_e27);
    rows = metal::uint2(own);
    uint _e36 = flb_volumes[record];
    if (_e36 >= FLB_PLANT_TILTED) {
        metal::float3 _e41 = flb_volume_floats(record + 1u, flb_volumes, _buffer_sizes);
        float w = metal::sqrt(metal::max(0.0, 1.0 - metal::dot(_e41, _e41)));
        metal::float3 _e48 = flb_volume_floats(sun, flb_volumes, _buffer_sizes);
        metal::float3 once = metal::cross(_e41, _e48);
        metal::float3 seen = _e48 + (2.0 * (metal::cross(_e41, once) - (w * once)));
        float across = metal::length(seen.xz);
        if (across > 0.0) {
            azimuth_deg = ((metal::atan2(seen.x, -(seen.z))) * 57.295779513082322865);
        }
        float elevation_deg = ((metal::atan2(seen.y, metal::max(across, 0.000000001))) * 57.295779513082322865);
        uint _e76 = flb_volumes[sun + FLB_SUN_AZIMUTH];
        float sun_azimuth_deg = as_type<float>(_e76);
        float _e78 = azimuth_deg;
        turn = (((sun_azimuth_deg - _e78) / 360.0) + 2.0) * static_cast<float>(yaws);
        float _e86 = turn;
        float _e87 = turn;
        turn = _e86 - (metal::floor(_e87 / static_cast<float>(yaws)) * static_cast<float>(yaws));
        uint _e98 = flb_volumes[sun + FLB_SUN_ELEVATION];
        float sun_deg = as_type<float>(_e98);
        uint _e104 = flb_volumes[species + FLB_SPECIES_STEP_DEG];
        float step_deg = as_type<float>(_e104);
        float wide = static_cast<float>(stride);
        float low_1 = static_cast<float>(own) + (metal::floor((elevation_deg - sun_deg) / (step_deg * wide)) * wide);
        uint _e122 = flb_volumes[sun + FLB_SUN_TOP_ROW];
        metal::float2 between = metal::clamp(metal::float2(low_1, low_1 + wide), metal::float2(0.0), metal::float2(static_cast<float>(_e122)));
        metal::float2 heights_deg = metal::clamp(metal::float2(sun_deg) + ((between - metal::float2(static_cast<float>(own))) * step_deg), metal::float2(-90.0), metal::float2(90.0));
        rows = naga_f2u32(between);
        float _e146 = flb_share((elevation_deg - heights_deg.x) / metal::max(heights_deg.y - heights_deg.x, 0.001));
        second_row = _e146;
    }
    float _e147 = turn;
    uint first_1 = naga_div(metal::min(naga_f2u32(_e147), yaws - 1u), stride) * stride;
    uint span = metal::min(stride, yaws - first_1);
    float _e156 = turn;
    float _e161 = flb_share((_e156 - static_cast<float>(first_1)) / static_cast<float>(span));
    metal::uint2 _e162 = rows;
    float _e166 = second_row;
    return FlbCells {_e162, metal::uint2(first_1, naga_mod(first_1 + span, yaws)), _e166, _e161};
}

metal::float3 flb_light(
    uint forest,
    uint plant,
    metal::float3 point_m_1,
    device type_2 const& flb_volumes,
    constant _mslBufferSizes& _buffer_sizes
) {
    metal::float3 light_2 = {};
    uint age = 0u;
    uint part = {};
    uint _e7 = flb_volumes[forest + FLB_FOREST_MAX_PLANTS];
    if (plant >= _e7) {
        return metal::float3(0.0);
    }
    uint _e15 = flb_volumes[forest + FLB_FOREST_PLANTS];
    uint record_1 = (forest + _e15) + (FLB_PLANT * plant);
    uint _e22 = flb_volumes[record_1];
    if (_e22 == 0u) {
        return metal::float3(0.0);
    }
    uint _e29 = flb_volumes[record_1];
    uint species_1 = forest + (_e29 & 2147483647u);
    uint yaws_1 = flb_volumes[species_1];
    metal::float3 _e38 = flb_volume_floats(species_1 + FLB_SPECIES_REST, flb_volumes, _buffer_sizes);
    light_2 = _e38;
    uint2 loop_bound_2 = uint2(4294967295u);
    bool loop_init_2 = true;
    while(true) {
        if (metal::all(loop_bound_2 == uint2(0u))) { break; }
        loop_bound_2 -= uint2(loop_bound_2.y == 0u, 1u);
        if (!loop_init_2) {
            uint _e126 = age;
            age = _e126 + 1u;
        }
        loop_init_2 = false;
        uint _e42 = age;
        if (_e42 < 2u) {
        } else {
            break;
        }
        {
            uint _e48 = age;
            uint _e51 = flb_volumes[(species_1 + FLB_SPECIES_FACTOR) + _e48];
            float factor = as_type<float>(_e51);
            if (factor == 0.0) {
                continue;
            }
            uint _e58 = age;
            FlbCells _e61 = flb_cells(record_1, species_1, (species_1 + FLB_SPECIES_SUNS) + (FLB_SUN * _e58), flb_volumes, _buffer_sizes);
            part = 0u;
            uint2 loop_bound_3 = uint2(4294967295u);
            bool loop_init_3 = true;
            while(true) {
                if (metal::all(loop_bound_3 == uint2(0u))) { break; }
                loop_bound_3 -= uint2(loop_bound_3.y == 0u, 1u);
                if (!loop_init_3) {
                    uint _e123 = part;
                    part = _e123 + 1u;
                }
                loop_init_3 = false;
                uint _e64 = part;
                if (_e64 < 4u) {
                } else {
                    break;
                }
                {
                    uint _e67 = part;
                    uint _e72 = part;
                    metal::bool2 is_second = metal::bool2((_e67 & 1u) == 1u, _e72 >= 2u);
                    float of_yaw = is_second.x ? _e61.second_yaw : (1.0 - _e61.second_yaw);
                    float of_row = is_second.y ? _e61.second_row : (1.0 - _e61.second_row);
                    float share_1 = (factor * of_yaw) * of_row;
                    if (share_1 == 0.0) {
                        continue;
                    }
                    uint row = is_second.y ? _e61.rows.y : _e61.rows.x;
                    uint cell = (row * yaws_1) + (is_second.x ? _e61.yaws.y : _e61.yaws.x);
                    uint _e112 = age;
                    uint volume_2 = flb_volumes[((species_1 + FLB_SPECIES_VOLUMES) + (2u * cell)) + _e112];
                    if (volume_2 != 0u) {
                        metal::float3 _e118 = light_2;
                        metal::float3 _e120 = flb_volume(forest + volume_2, point_m_1, flb_volumes, _buffer_sizes);
                        light_2 = _e118 + (share_1 * _e120);
                    }
                }
            }
        }
    }
    metal::float3 _e129 = light_2;
    return _e129;
}
