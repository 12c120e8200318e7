#!/usr/bin/env python3
"""Holds our Monte Carlo light (transport/src/monte_carlo.rs) against Mitsuba 3, an independent code, in the same voxel medium.

    python3 -m venv /tmp/mitsuba && /tmp/mitsuba/bin/pip install mitsuba==3.9.1 numpy
    /tmp/mitsuba/bin/python tests/mitsuba/compare.py [--walks 1000000] [--photons 16000000] [--case NAME]... [--planted 10]

The medium is a crown of clumps and holes in 16^3, made here, and both codes get the same numbers. Mitsuba's `volpath`
traces back from random points of random non-empty sites in random directions: 4 pi times the mean radiance is the
scattered fluence. Ours comes from `cargo run --release -p flb-baker --example monte_carlo`. Compared are the mean
over all non-empty sites and the means over layers of sites that lie at like depths under the sun.

Exit code 1 if a mean differs by more than 4 standard errors of the difference, or if that error is above 1 % for the mean
over all sites (then the comparison says nothing: raise --walks). `--planted 10` gives Mitsuba a medium that is 10 % too dense: that
must be found.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import mitsuba
import numpy

LATTICE, SPACING_M = 16, 0.25
LAYERS = 5
MAX_ERRORS, MAX_ERROR_PERCENT = 4.0, 1.0
ROOT = pathlib.Path(__file__).resolve().parents[2]

# name: albedo, g or transmitted, towards the sun
CASES = {
    "isotropic, overhead": (0.9, {"g": 0.0}, (0.0, 1.0, 0.0)),
    "forward, oblique": (0.9, {"g": 0.5}, (0.48, 0.8, 0.36)),
    "backward, low": (0.3, {"g": -0.4}, (-0.8, 0.36, 0.48)),
    "leaves, oblique": (0.9, {"transmitted": 0.4}, (0.48, 0.64, -0.6)),
    "reflecting leaves, oblique": (0.6, {"transmitted": 0.1}, (0.48, 0.8, 0.36)),
}


def crown():
    """Extinction in m^-1, [z][y][x]: clumps of unlike density, with holes, about an optical depth of 5 across."""
    draw = numpy.random.default_rng(7)
    z, y, x = numpy.meshgrid(*[numpy.arange(LATTICE) + 0.5] * 3, indexing="ij")
    extinction = numpy.zeros((LATTICE,) * 3)
    for _ in range(25):
        centre = 8 + draw.uniform(-4, 4, 3)
        size, density = draw.uniform(1.5, 3), draw.exponential(1.0)
        away = numpy.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2)
        extinction += numpy.where(away < size, density * draw.random(extinction.shape), 0)
    inside = numpy.ones_like(extinction, bool)
    for axis in (x, y, z):
        inside &= (axis > 2) & (axis < LATTICE - 2)
    return numpy.where(inside, extinction, 0).astype(numpy.float32)


def ours(extinction, case, photons):
    """What the example prints, as arrays over the non-empty sites."""
    albedo, phase, toward = case
    task = dict(lattice=LATTICE, spacing_m=SPACING_M, albedo=albedo, toward_sun=toward, photons=photons, seed=1, **phase)
    task["extinction_per_m"] = [float(value) for value in extinction.ravel()]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(task, file)
        file.flush()
        command = ["cargo", "run", "--release", "-q", "-p", "flb-baker", "--example", "monte_carlo", "--", file.name]
        light = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    return {name: numpy.array(light[name]) for name in ("site", "scattered", "error", "uncollided", "mean_error")}


def mitsuba_phase(phase):
    if "g" in phase:
        return {"type": "hg", "g": phase["g"]}
    # Facets oriented at random (Ross, 1981), tabulated over the cosine. Mitsuba's incoming direction points back to
    # where light comes from, and its tables run over the cosine with that direction turned round.
    cosine = numpy.linspace(-1, 1, 2001)

    def lambert_sphere(cosine):
        angle = numpy.arccos(cosine)
        return numpy.sin(angle) - angle * cosine

    through = phase["transmitted"]
    values = (1 - through) * lambert_sphere(cosine) + through * lambert_sphere(-cosine)
    return {"type": "tabphase", "values": ", ".join(f"{value:.9g}" for value in values)}


def mitsuba_walks(extinction, case, sites, walks, seed):
    """Radiance times 4 pi along `walks` random lines back from random points of random sites; which site each was in."""
    albedo, phase, toward = case
    extent = LATTICE * SPACING_M
    to_world = mitsuba.ScalarTransform4f().scale(extent)
    grid = mitsuba.VolumeGrid(extinction[..., None])
    scene = mitsuba.load_dict({
        "type": "scene",
        "sun": {"type": "directional", "direction": [-c for c in toward], "irradiance": {"type": "rgb", "value": 1.0}},
        "box": {
            "type": "cube",
            # Mitsuba's cube is -1..1.
            "to_world": mitsuba.ScalarTransform4f().scale(extent / 2).translate([1, 1, 1]),
            "bsdf": {"type": "null"},
            "interior": {
                "type": "heterogeneous",
                "albedo": {"type": "constvolume", "value": albedo},
                "sigma_t": {"type": "gridvolume", "grid": grid, "filter_type": "nearest", "raw": True, "to_world": to_world},
                "phase": mitsuba_phase(phase),
            },
        },
    })
    integrator = mitsuba.load_dict({"type": "volpath", "max_depth": -1, "rr_depth": 50})
    medium = scene.shapes()[0].interior_medium()
    sampler = mitsuba.load_dict({"type": "independent"})
    sampler.seed(seed)
    draw = numpy.random.default_rng(seed)
    chosen = draw.integers(len(sites), size=walks)
    site = sites[chosen]
    low = numpy.stack([site % LATTICE, site // LATTICE % LATTICE, site // LATTICE**2], axis=1)
    points = (low + draw.random((walks, 3))) * SPACING_M
    directions = draw.normal(size=(walks, 3))
    directions /= numpy.linalg.norm(directions, axis=1)[:, None]
    light = numpy.empty(walks)
    for i in range(walks):
        ray = mitsuba.Ray3f(points[i].tolist(), directions[i].tolist())
        radiance, _, _ = integrator.sample(scene, sampler, ray, medium)
        light[i] = 4 * math.pi * radiance[0]
    return light, chosen


def compare(name, case, extinction, arguments):
    """Prints a table; whether both codes agree."""
    our = ours(extinction, case, arguments.photons)
    theirs_per_m = extinction * numpy.float32(1 + arguments.planted / 100)
    light, chosen = mitsuba_walks(theirs_per_m, case, our["site"], arguments.walks, list(CASES).index(name))
    # Layers by how much of the beam is left: no site order, no geometry to get wrong.
    rank = numpy.argsort(numpy.argsort(-our["uncollided"]))
    layer = rank * LAYERS // len(rank)
    print(f"{name}: albedo {case[0]}, {case[1]}, sun {case[2]}, {len(rank)} sites")
    print("  sites            Mitsuba  +-        ours     +-        difference")
    agreed = True
    for part in [None, *range(LAYERS)]:
        within = numpy.ones(len(rank), bool) if part is None else layer == part
        theirs = light[within[chosen]]
        mean, error = theirs.mean(), theirs.std(ddof=1) / math.sqrt(len(theirs))
        own = our["scattered"][within].mean()
        # Sites share photons: at most, the mean of a layer is as uncertain as its sites are.
        own_error = float(our["mean_error"]) if part is None else our["error"][within].mean()
        both = math.hypot(error, own_error)
        percent, share = 100 * (own / mean - 1), 100 * both / mean
        fits = abs(own - mean) <= MAX_ERRORS * both and (part is not None or share <= MAX_ERROR_PERCENT)
        agreed &= fits
        label = "all" if part is None else f"lit, fifth {part + 1}"
        print(
            f"  {label:15} {mean:.5f}  {error:.5f}   {own:.5f}  {own_error:.5f}   {percent:+.2f} % +- {share:.2f}"
            + ("" if fits else "   DIFFERS")
        )
    return agreed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--walks", type=int, default=1_000_000, help="Mitsuba's paths per case")
    parser.add_argument("--photons", type=int, default=16_000_000, help="our photons per case")
    parser.add_argument("--case", action="append", choices=CASES, help="default: all")
    parser.add_argument("--planted", type=float, default=0, help="make Mitsuba's medium denser by this many percent")
    arguments = parser.parse_args()
    if min(arguments.walks, arguments.photons) < 1000:
        parser.error("expected at least 1000 walks and photons")
    mitsuba.set_variant("scalar_rgb")
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    print(f"Mitsuba {mitsuba.__version__}, {arguments.walks} walks; ours, {arguments.photons} photons")
    extinction = crown()
    agreed = [compare(name, CASES[name], extinction, arguments) for name in arguments.case or CASES]
    print(f"{sum(agreed)} of {len(agreed)} cases agree within {MAX_ERRORS} standard errors")
    return 0 if all(agreed) else 1


if __name__ == "__main__":
    sys.exit(main())
