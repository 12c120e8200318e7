"""Section 9 of SPEC.md: the metadata of a species, for reader.py."""
import json, re, unicodedata
from decimal import Decimal

import suns
from faults import FlbError, need

def canonical(value):
    if isinstance(value, list):
        return "[" + ",".join(canonical(item) for item in value) + "]"
    if isinstance(value, dict):
        keys = sorted(value, key=lambda key: key.encode("utf-16-be"))
        return "{" + ",".join(canonical(k) + ":" + canonical(value[k]) for k in keys) + "}"
    if value is None or isinstance(value, (str, bool)):
        return json.dumps(value, ensure_ascii=False)  # escapes strings as M31 wants
    if value % 1 == 0:
        need(abs(value) <= 1 << 53, 5002, "metadata: number over 2^53")
        return str(int(value))
    if abs(value) >= 1e-6:
        return format(Decimal(repr(value)), "f")  # repr gives the fewest digits
    mantissa, exponent = repr(value).split("e")
    return f"{mantissa}e{int(exponent)}"
def finite(text):
    if not abs(float(text)) < float("inf"):
        raise ValueError(f"{text} is no number, or too large")
    return int(text) if text.lstrip("-").isdigit() else float(text)
FINITE = {"parse_constant": finite, "parse_int": finite, "parse_float": finite}
def check_text(text):
    """JSON of any depth: each array or object by itself, what it holds replaced by a number."""
    deepest, opened = 0, [""]
    for token in re.findall(r'"(?:[^"\\]|\\.)*"|[][{}"]|[^][{}"]+', text, re.S) + [""]:
        opened += [""] if token in ("[", "{") else []
        opened[-1] += token
        if token in ("]", "}", ""):  # pairs: a name twice hides no value
            values = json.loads(opened[-1], object_pairs_hook=list, **FINITE)
            json.dumps(values, ensure_ascii=False).encode()  # no lone surrogate
            opened[-2:] = [opened[-2] + " 0 "] if len(opened) > 1 else opened
        deepest = max(deepest, len(opened) - 1)
    return deepest
def read_metadata(text):
    try:
        deepest = check_text(text.decode())
    except ValueError as error:
        raise FlbError(5001, f"metadata: {error}") from error
    need(deepest <= 32, 5002, "metadata: nested too deep")
    value = json.loads(text, **FINITE)
    need(canonical(value).encode() == text, 5002, "metadata: not canonical")
    check_metadata(value)
    return value
printable = lambda c: unicodedata.category(c) != "Cc"
HIDDEN = ((0x0, 0x1F), (0x7F, 0x9F), (0xAD, 0xAD), (0x34F, 0x34F), (0x61C, 0x61C), (0x115F, 0x1160), (0x17B4, 0x17B5),
          (0x180B, 0x180F), (0x200B, 0x200F), (0x2028, 0x202E), (0x2060, 0x206F), (0x3164, 0x3164), (0xFE00, 0xFE0F),
          (0xFEFF, 0xFEFF), (0xFFA0, 0xFFA0), (0xFFF0, 0xFFFB), (0x1BCA0, 0x1BCA3), (0x1D173, 0x1D17A), (0xE0000, 0xE0FFF))
shown = lambda c: not any(first <= ord(c) <= last for first, last in HIDDEN)
def is_name(value):
    plain = isinstance(value, str) and all(c not in "/\\" and shown(c) for c in value)
    return plain and 1 <= len(value.encode()) <= 255 and value not in (".", "..")
is_digest = lambda value: isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value)
real = lambda low, high: lambda value: type(value) in (int, float) and low <= value <= high
POINT = [real(-1e9, 1e9)] * 3
CLASS, SHARE, ERROR = {"sigma_a": real(0, 1), "g": real(-1, 1)}, real(0, 1), real(0, float("inf"))
COUNT = lambda value: type(value) is int and value >= 0
COUNT_32 = lambda value: COUNT(value) and value < 1 << 32
LEANING = ("", ',"leaning":true')
SUNS = ['{"kind":"lattice18"}'] + ['{"degree":%d,"kind":"harmonics"%s,"reaches":%s}' % (d, l, s) for d in (1, 2, 3) for l in LEANING for s in ("[1,3,8]", '[8],"single":true')]
def total(values):
    result = 0.0
    for value in values:  # sum() may compensate
        result += value
    return result
def is_angles(value):
    fits = isinstance(value, list) and len(value) == 32 and all(map(SHARE, value)) and value != [1 / 32] * 32
    return value == "spherical" or fits and abs(total(value) - 1) <= 1e-6
# M33: an object's members, those with ? optional; [x]: an array of x; [x, y, z]: an array of three; else what
# holds for the value.
SHAPE = {
    "name": is_name, "model": lambda value: isinstance(value, str) and value in MODELS,
    "tool": lambda value: isinstance(value, str) and 1 <= len(value.encode()) <= 1000 and all(map(printable, value)),
    "settings": lambda value: isinstance(value, dict),
    "grid": {"lattice": lambda value: type(value) is int and value in (16, 32, 64, 128, 256),
             "origin_m": POINT, "spacing_m": real(1e-9, 1e9)},
    "bounds_m": {"min": POINT, "max": POINT},
    "triangles": {"total": COUNT, "leaf": COUNT, "wood": COUNT},
    "sources": [{"name": is_name, "blake3": is_digest}],
}
MODELS = {
    "paper": {"optics": [{"name": is_name, "leaf": CLASS, "wood": CLASS}]},
    "physical": {
        "surfaces": [{"name": is_name, "wood": {"reflectance": SHARE},
                      "leaf": {"reflectance": SHARE, "transmittance": SHARE}}],
        "light": {"field": lambda value: value in ("scattered", "total"), "leaf_angles": is_angles,
                  "ordinates": lambda value: value in (18, 50, 110), "suns": lambda v: suns.check(v) if suns.is_list(v) else canonical(v) in SUNS,
                  "rays": lambda value: type(value) is int and 1 <= value <= 8, "solid_offset?": real(0, 2),
                  "error": {"suns_rms": ERROR, "solver": ERROR, "held_out": COUNT_32, "monte_carlo?": {
                      "rms": ERROR, "bias": real(-float("inf"), float("inf")), "photons": COUNT,
                      "suns": COUNT_32}}}},
}
bands_of = lambda meta: meta["optics" if meta["model"] == "paper" else "surfaces"]
def items_of(meta):
    """Numbers of items of kinds 2 and 3 that a species can have."""
    kind = meta["light"]["suns"] if meta["model"] == "physical" else {}
    harmonics = "degree" in kind and 1 + (kind["degree"] + 1)**2 + len(kind["reaches"]) + 1 + ("single" in kind)
    listed = "directions" in kind and 1 + len(kind["directions"])
    return (4 if meta["model"] == "paper" else 6), harmonics or listed or 19
def needs_all(meta):
    """M12, M38."""
    return meta["model"] == "physical" and meta["light"]["suns"]["kind"] != "lattice18"
MEAN = real(-float("inf"), float("inf"))
LEFT_OUT = {"bases": [lambda value: type(value) is int and 0 <= value <= 18], "bands": [is_name], "reason":
            lambda v: isinstance(v, str) and 1 <= len(v.encode()) <= 1000 and all(map(printable, v))}
def conform(value, shape, field):
    if isinstance(shape, dict):
        need(isinstance(value, dict), 5003, f"{field}: members")
        optional = {name[:-1] for name in shape if name[-1] == "?"} - set(value)
        need(set(value) | optional == {name.rstrip("?") for name in shape}, 5003, f"{field}: members")
        for name in value:
            conform(value[name], shape.get(name) or shape[name + "?"], f"{field}.{name}")
    elif isinstance(shape, list):
        need(isinstance(value, list) and len(shape) in (1, len(value)), 5003, f"{field}: array")
        for i, item in enumerate(value):
            conform(item, shape[i % len(shape)], f"{field}[{i}]")
    else:
        need(shape(value), 5003, field)
def check_materials(meta):
    """M60."""
    bands, found = len(bands_of(meta)), meta["settings"].get("surfaces.materials", [])
    need(isinstance(found, list), 5015, "surfaces.materials: array")
    for entry in (entry for entry in found if entry is not None):
        members = isinstance(entry, dict) and set(entry) == {"texel", "reflectance", "transmittance"}
        need(members and entry["texel"] in ("albedo", "tint"), 5015, "surfaces.materials: members or texel")
        for numbers in (entry["reflectance"], entry["transmittance"]):
            need(isinstance(numbers, list) and len(numbers) == bands, 5015, "surfaces.materials: bands")
            most = 1 if entry["texel"] == "tint" else 1e6
            need(all(map(real(0, most), numbers)), 5015, "surfaces.materials: number")
def check_metadata(meta):
    need(isinstance(meta, dict) and set(SHAPE) <= set(meta), 5003, "metadata: members")
    conform({name: meta[name] for name in SHAPE}, SHAPE, "metadata")
    shape, names = MODELS[meta["model"]], {name for model in MODELS.values() for name in model}
    conform({name: meta[name] for name in names & set(meta)}, shape, "metadata")
    low, high = meta["bounds_m"]["min"], meta["bounds_m"]["max"]
    names, count = {band["name"] for band in bands_of(meta)}, meta["triangles"]
    need(all(a <= b for a, b in zip(low, high)), 5003, "metadata.bounds_m")
    need(1 <= len(names) == len(bands_of(meta)) <= 64, 5003, "metadata: number or names of bands")
    sums = [sum(surface["leaf"].values()) for surface in meta.get("surfaces", [])]
    need(all(s <= 1 for s in sums), 5003, "metadata.surfaces: reflectance + transmittance")
    light = meta.get("light", {"suns": {}})
    leans = "leaning" not in light["suns"] or light["leaf_angles"] != "spherical" and light["field"] == "scattered"
    need(leans, 5003, "metadata.light.suns.leaning: of light that does not lean")
    need(count["leaf"] + count["wood"] <= count["total"], 5003, "metadata.triangles.total")
    need("mesh_blake3" not in meta or is_digest(meta["mesh_blake3"]), 5003, "metadata.mesh_blake3")
    if "mean_light" in meta:
        bands, mean = len(bands_of(meta)), meta["mean_light"]
        conform(mean, {"sky": [MEAN], "sun": [[MEAN]]}, "metadata.mean_light")
        need(len(mean["sky"]) in (0, bands), 5003, "metadata.mean_light.sky: bands")
        need(len(mean["sun"]) in (0, 1, 4, 9, 16), 5003, "metadata.mean_light.sun: harmonics")
        need(all(len(row) == bands for row in mean["sun"]), 5003, "metadata.mean_light.sun: bands")
    if "sky_averages" in meta:
        conform(meta["sky_averages"], [MEAN], "metadata.sky_averages")
        need(len(meta["sky_averages"]) == len(bands_of(meta)), 5003, "metadata.sky_averages: bands")
    if "left_out" in meta:
        conform(meta["left_out"], LEFT_OUT, "metadata.left_out")
        bands, bases, _ = meta["left_out"].values()  # in canonical order
        need(bases == sorted(set(bases)) and len(bands) == len(set(bands)), 5003, "metadata.left_out: twice")
        need(not bases or not needs_all(meta), 5003, "metadata.left_out.bases: of other suns than lattice18")
        need((bases or bands) and not names & set(bands), 5003, "metadata.left_out: empty or present")
