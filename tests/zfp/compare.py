#!/usr/bin/env python3
"""What zfp's fixed rate (Lindstrom 2014) takes for the fields of a file, at an error of ours: the peer of codec `classed`.

    python3 -m venv /tmp/zfp && /tmp/zfp/bin/pip install zfpy numpy
    flb bake PLANT -o plant.flb --keep-fields plant.fields.flb
    /tmp/zfp/bin/python tests/zfp/compare.py plant.fields.flb [--db 45]... [--most-bytes N]

zfp gets what our codec has: the same blocks (those that hold a texel within one site of a non-empty one), and bands turned by the
same kind of rotation. The error is ours too: trilinear samples at two points of each non-empty site, each base to its own
largest sample. zfp takes any whole number of bits for 4^3 values; of the second and third component the numbers are tried in turn, and
bytes of the first one are interpolated between those tried, in zfp's favour. It is not given filled texels, which are a trick of our encoder.

Prints bytes of all bases for each error. Exit code 1 if they are above --most-bytes, or a base cannot have that error.
"""

import argparse
import pathlib
import sys

import numpy
import zfpy

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "format-spec"))
import reader  # noqa: E402

FIRST_BITS = (12, 16, 24, 32, 48, 64, 80, 96, 112, 128, 144, 160, 176, 192, 208, 224, 256, 288, 320, 384, 448, 512)
OTHER_BITS = (12, 16, 24, 32, 48, 64, 96, 128, 160, 192, 256, 320)


def load(path):
    """Non-empty sites [z][y][x], and fields [band][z][y][x] by base."""
    file = reader.File(pathlib.Path(path).read_bytes())
    owner = file.species[0]  # sections by kind (SPEC.md section 4) and item
    classes = numpy.array(reader.decode_sparse(file, owner[2][1]), dtype=numpy.uint8)
    n = round(len(classes) ** (1 / 3))
    ambient = 18.0 if owner["meta"]["model"] == "paper" else 1.0
    for number, section in owner[3].items():
        field = numpy.array(reader.decode_base(file, section, ambient), dtype=numpy.float32)
        yield classes.reshape(n, n, n) > 0, number, field.reshape(-1, n, n, n)


def surface_points(non_empty):
    """packer/src/quality.rs, `surface_point`: two for each site."""
    n = non_empty.shape[0]
    site = numpy.flatnonzero(non_empty.ravel()).astype(numpy.uint64)
    points = []
    for k in range(2):
        h = (site * numpy.uint64(2) + numpy.uint64(k + 1)) * numpy.uint64(0x9E3779B97F4A7C15)
        h = (h ^ (h >> numpy.uint64(30))) * numpy.uint64(0xBF58476D1CE4E5B9)
        h = (h ^ (h >> numpy.uint64(27))) * numpy.uint64(0x94D049BB133111EB)
        h ^= h >> numpy.uint64(31)
        at = site % n, site // n % n, site // (n * n)
        parts = [(h >> numpy.uint64(20 * a)) & numpy.uint64(0xFFFFF) for a in range(3)]
        points.append(numpy.stack([at[a] + parts[a] / 1048576.0 for a in range(3)], 1))
    return numpy.concatenate(points)


class Samples:
    """Trilinear samples of volumes at fixed points."""

    def __init__(self, points, n):
        place = numpy.clip(points - 0.5, 0, n - 1)
        texel = numpy.minimum(place.astype(int), n - 2)
        part = place - texel
        self.texels, self.weights = [], []
        for corner in range(8):
            upper = [corner >> a & 1 for a in range(3)]
            x, y, z = (texel[:, a] + upper[a] for a in range(3))
            self.texels.append((z * n + y) * n + x)
            self.weights.append(numpy.prod([part[:, a] if upper[a] else 1 - part[:, a] for a in range(3)], 0))

    def of(self, volume):
        flat = volume.ravel()
        return sum(flat[t] * w for t, w in zip(self.texels, self.weights))


def to_blocks(volume):
    m = volume.shape[0] // 4
    return volume.reshape(m, 4, m, 4, m, 4).transpose(0, 2, 4, 1, 3, 5).reshape(-1, 4, 4, 4)


def to_volume(blocks, n):
    m = n // 4
    return blocks.reshape(m, m, m, 4, 4, 4).transpose(0, 3, 1, 4, 2, 5).reshape(n, n, n)


def near_blocks(non_empty):
    n = non_empty.shape[0]
    padded = numpy.pad(non_empty, 1)
    near = numpy.zeros_like(non_empty)
    for shift in numpy.ndindex(3, 3, 3):
        near |= padded[tuple(slice(s, s + n) for s in shift)]
    return to_blocks(near).any((1, 2, 3))


def curve(values, near, n, samples, truth, choices):
    """(bytes, mean square error of samples) of one component: without it first, then at each rate."""
    points = [(0.0, float((truth**2).mean()))]
    for bits in choices:
        stored = numpy.ascontiguousarray(values.reshape(-1, 4, 4), dtype=numpy.float32)
        decoded = zfpy.decompress_numpy(zfpy.compress_numpy(stored, rate=bits / 64, write_header=True))
        whole = numpy.zeros((len(near), 4, 4, 4), numpy.float32)
        whole[near] = decoded.reshape(values.shape)
        error = samples.of(to_volume(whole, n)) - truth
        points.append((bits * len(values) / 8, float((error**2).mean())))
    return points


def least_bytes(curves, target):
    """Fewest bytes for a sum of mean squares."""
    first, others = curves[0], [(0.0, 0.0)]
    for other in curves[1:]:
        others = [(b + c, e + f) for b, e in others for c, f in other]
    best = numpy.inf
    for size, error in others:
        left = target - error
        for (small, worse), (large, better) in zip(first, first[1:]):
            if better <= left <= worse:
                share = numpy.log(worse / left) / numpy.log(worse / better)
                best = min(best, small + share * (large - small) + size)
    return best


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("file")
    arguments.add_argument("--db", type=float, action="append")
    arguments.add_argument("--most-bytes", type=float, default=numpy.inf)
    options = arguments.parse_args()
    totals = {db: 0.0 for db in options.db or [45.0]}
    samples = near = None
    for non_empty, number, field in load(options.file):
        n = non_empty.shape[0]
        if samples is None:
            samples, near = Samples(surface_points(non_empty), n), near_blocks(non_empty)
        truth = numpy.stack([samples.of(band) for band in field])
        peak = numpy.abs(truth).max()
        rotation = numpy.linalg.eigh(truth @ truth.T)[1].T[::-1]
        turned = numpy.einsum("cb,bnzyx->cnzyx", rotation, numpy.stack([to_blocks(band)[near] for band in field]) / peak)
        truth = rotation @ truth / peak
        curves = [
            curve(turned[c], near, n, samples, truth[c], OTHER_BITS if c else FIRST_BITS) for c in range(len(field))
        ]
        for db in totals:
            size = least_bytes(curves, len(field) * 10 ** (-db / 10))
            if not numpy.isfinite(size):
                print(f"base {number}: no rate has {db} dB", file=sys.stderr)
                return 1
            totals[db] += size
    for db, size in totals.items():
        print(f"{db} dB: {round(size)} bytes in {near.sum()} blocks")
    return int(max(totals.values()) > options.most_bytes)


if __name__ == "__main__":
    sys.exit(main())
