"""Blocks near geometry (SPEC.md section 8.5), for reader.py: payloads to fields.

Written from the text alone, in integers but for the last step; rule numbers (M40...) are the text's.
"""
import struct
from array import array
from operator import add

from faults import need

def morton(edge):
    """All places (x, y, z) of a cube in Morton order: eight cubes of half the edge, one after another."""
    if edge == 1:
        return [(0, 0, 0)]
    half = edge // 2
    return [(x + half * (o & 1), y + half * (o >> 1 & 1), z + half * (o >> 2))
            for o in range(8) for x, y, z in morton(half)]

class Bits:
    """A bit payload: fields of bits, the lowest first, in u32 words."""
    def __init__(self, data, code, name):
        self.data, self.code, self.name, self.at = data, code, name, 0
    def take(self, width):
        start, self.at = self.at, self.at + width
        self.need(self.at <= 8 * len(self.data), "ends within a field")
        window = int.from_bytes(self.data[start // 8:(self.at + 7) // 8], "little")
        return window >> start % 8 & (1 << width) - 1
    def end(self):
        words = max(1, (self.at + 31) // 32)
        self.need(len(self.data) == 4 * words, f"{len(self.data)} bytes, not {words} words")
        self.need(self.take(32 * words - self.at) == 0, "bits behind the last field")
    def need(self, holds, message):
        need(holds, self.code, f"{self.name}: {message}")

# --- what the bases of a species share: block map, class tables -------------------------------------
class Map:
    """Which blocks are stored: their places by rank, and for each the ranks of its neighbours before it."""
    def __init__(self, payload, lattice, name):
        edge = lattice // 4  # M40 holds by the section's units (4.1) and M19
        self.lattice = lattice
        self.stored = [at for code, at in enumerate(morton(edge)) if payload[code // 8] >> code % 8 & 1]
        need(self.stored, 5010, f"{name}: no block is stored")  # M41
        self.before = neighbours(self.stored)
        self.coarse = morton(lattice // 16) if len(self.stored) < edge**3 else []
def neighbours(places):
    index = {place: i for i, place in enumerate(places)}
    return [[index[at] for at in ((x - 1, y, z), (x, y - 1, z), (x, y, z - 1)) if at in index]
            for x, y, z in places]
def read_classes(payload, name):
    """The two class tables: per class the widths of places 0 to 63; that of place 0 is 0."""
    def fits(holds, reason):
        need(holds, 5011, f"{name}: {reason}")
    counts = struct.unpack_from("<2H", payload)  # there by the section's units
    fits(all(1 <= count <= 256 for count in counts), f"{counts} classes")  # M42
    fits(len(payload) == 4 + 32 * sum(counts), "length")
    tables, at = [], 4
    for count in counts:
        tables.append([])
        for end in range(at + 32, at + 32 * count + 1, 32):
            numbers = [byte >> shift & 15 for byte in payload[end - 32:end] for shift in (0, 4)]
            fits(max(numbers) <= 11 and numbers[63] == 0, "a width over 11, or number 63")  # M43
            tables[-1].append([0] + numbers[:63])
        order = [(sum(widths), widths) for widths in tables[-1]]
        fits(all(a < b for a, b in zip(order, order[1:])), "order of classes")  # M44
        at += 32 * count
    return tables

# --- codec 11: head and averages of a base ----------------------------------------------------------
class Head:
    def __init__(self, payload, bands, name):
        def fits(holds, field):
            need(holds, 5012, f"{name}: {field}")
        self.components = payload[0]
        self.bytes = 32 + 4 * self.components * bands
        fits(len(payload) >= self.bytes, "length of the head")  # M45
        axes, self.unit, *self.thresholds = struct.unpack_from("<3sf3i", payload, 1)
        measured = payload[20:32]  # peak, rms_error, dark_error
        self.rotation = struct.unpack_from(f"<{self.components * bands}f", payload, 32)
        fits(1 <= self.components <= bands, "components")  # from here M46
        fits(sorted(axes) == [0, 1, 2], "axes")
        fits(2.0**-126 <= self.unit <= 2.0**88, "unit")
        fits(32768 >= self.thresholds[0] >= self.thresholds[1] >= self.thresholds[2] >= 0, "thresholds")
        # +0 to 2^96: as bits, these are in order
        fits(all(bits <= 0x6F800000 for bits in struct.unpack("<3I", measured)), "peak or errors")
        fits(all(-1 <= value <= 1 for value in self.rotation), "rotation")
        words = struct.unpack_from(f"<{len(self.rotation)}I", payload, 32)
        fits(0x80000000 not in words, "rotation: -0")
        # Index of the coefficient at each place.
        self.index = [sum((p >> 2 * d & 3) << 2 * axes[d] for d in range(3)) for p in range(64)]
    def halvings(self, average):
        return sum(t > abs(average) for t in self.thresholds)
def spent(z, k):
    """Bits of the number z with the parameter k, but for those of k itself."""
    return (z >> k) + 1 + k if z >> k < 20 else 37
def read_sequence(bits, before):
    """Averages; before[i] lists the ones that average i is predicted from."""
    values = []
    for start in range(0, len(before), 32):
        k, numbers = bits.take(5), []
        for _ in before[start:start + 32]:
            ones = 0
            while ones < 20 and bits.take(1):
                ones += 1
            z = ones << k | bits.take(k) if ones < 20 else bits.take(17)
            bits.need(ones < 20 or z >> k >= 20, f"{z} in 17 bits")
            numbers.append(z)
        costs = [sum(spent(z, k) for z in numbers) for k in range(18)]
        bits.need(costs.index(min(costs)) == k, f"parameter {k} of 0 to 17 is not the best")  # M48
        for z, ranks in zip(numbers, before[start:start + 32]):
            near = [values[rank] for rank in ranks] or values[-1:] or [0]
            value = sum(near) // len(near) + (-(z + 1) // 2 if z % 2 else z // 2)
            bits.need(-32768 <= value <= 32767, f"average {value}")  # M49
            values.append(value)
    return values
def read_averages(payload, blocks, head, name):
    """Per component the coarse averages (none where all blocks are stored) and those of the blocks."""
    bits = Bits(payload[head.bytes:], 5013, name)
    around = neighbours(blocks.coarse)
    coarse = [read_sequence(bits, around) for _ in range(head.components)]
    averages = [read_sequence(bits, blocks.before) for _ in range(head.components)]
    bits.end()
    return coarse, averages

# --- codecs 7 and 8: detail, block by block, as [component][index of a coefficient] -----------------
def read_classed(bits, tables, head, halvings):
    used = [tables[min(c, 1)] for c in range(head.components)]
    numbers = [[bits.take((len(table) - 1).bit_length()) for _ in halvings] for table in used]
    for table, row in zip(used, numbers):
        bits.need(max(row) < len(table), f"class {max(row)} of {len(table)}")  # M52
    for b, h in enumerate(halvings):
        detail = [[0] * 64 for _ in used]
        for table, row, coefficients in zip(used, numbers, detail):
            widths = table[row[b]]
            for place in sorted(range(64), key=lambda p: -widths[p]):  # sorts stably
                if w := widths[place]:
                    coefficients[head.index[place]] = (2 * bits.take(w) + 1 - (1 << w)) << 3 - h
        yield detail
def read_haar(bits, _, head, halvings):
    widths = [[bits.take(4) for _ in halvings] for _ in range(head.components)]
    masks = [[bits.take(64) if row[b] else 0 for row in widths] for b in range(len(halvings))]
    for b, h in enumerate(halvings):
        detail = [[0] * 64 for _ in widths]
        for row, mask, coefficients in zip(widths, masks[b], detail):
            w, values = row[b], []
            bits.need(w <= 11, f"width {w}")  # M53
            bits.need(w == 0 or mask > 1 and mask % 2 == 0, f"mask {mask:x}")
            for place in (p for p in range(64) if mask >> p & 1):
                v = bits.take(w) - (1 << w - 1)
                values.append(v)
                coefficients[head.index[place]] = 2 * (v if v < 0 else v + 1) << 3 - h
            least = 1 << w - 2 if w > 1 else 0
            bits.need(w < 2 or min(values) < -least or max(values) >= least, f"width {w} is not needed")
        yield detail

# --- decoding: section 8.5.5 ------------------------------------------------------------------------
READERS = {7: read_classed, 8: read_haar}
ROWS = {7: ((3, 3, 3, 3), (4, 2, -2, -4), (4, -4, -4, 4), (3, -6, 6, -3)),
        8: ((3, 3, 3, 3), (3, 3, -3, -3), (5, -5, 0, 0), (0, 0, 5, -5))}
LINES = [slice(i, i + 3 * step + 1, step) for step in (1, 4, 16) for i in range(64) if i // step % 4 == 0]
def texels_of(values, rows):
    """Coefficients of a block to texels: along x, then y, then z."""
    columns = list(zip(*rows))
    for line in LINES:
        k0, k1, k2, k3 = values[line]
        values[line] = [k0 * r0 + k1 * r1 + k2 * r2 + k3 * r3 for r0, r1, r2, r3 in columns]
    return values
def between(coarse, places, n):
    """All n^3 texels as those of blocks that are not stored."""
    grid, edge = dict(zip(places, coarse)), n // 16
    weights = []
    for x in range(n):
        i, f = divmod(min(max(2 * x - 15, 0), 32 * (edge - 1)), 32)
        weights.append(((i, 32 - f), (min(i + 1, edge - 1), f)))
    return [27 * (sum(grid[i, j, k] * a * b * c for k, c in z for j, b in y for i, a in x) // 2048)
            for z in weights for y in weights for x in weights]
def decode(payload, name, blocks, bands, codec, tables, pages):
    """A base as [band][z][y][x], from its payload of codec 11 and, for each page of its detail, the name,
    the rank of the first block, the number of blocks, and a function that gives the payload."""
    n, head = blocks.lattice, Head(payload, bands, name)
    coarse, averages = read_averages(payload, blocks, head, name)
    texels = [between(values, blocks.coarse, n) for values in coarse] if blocks.coarse else []
    texels = texels or [[0] * n**3 for _ in averages]
    read_bytes = 0
    for page, first, count, read in pages:
        data = read()
        read_bytes += len(data)
        need(read_bytes <= (1 << 29) - 132, 5014, f"{page}: the base's pages are too long")  # M54
        bits = Bits(data, 5014, page)
        halvings = [head.halvings(average) for average in averages[0][first:first + count]]
        for rank, detail in enumerate(READERS[codec](bits, tables, head, halvings), first):
            bx, by, bz = blocks.stored[rank]
            for field, average, coefficients in zip(texels, averages, detail):
                coefficients[0] = 16 * average[rank]
                block = texels_of(coefficients, ROWS[codec])
                for row in range(16):
                    to = ((4 * bz + row // 4) * n + 4 * by + row % 4) * n + 4 * bx
                    field[to:to + 4] = block[4 * row:4 * row + 4]
        bits.end()
    values = array("f")  # rounds to binary32
    for band in range(bands):
        total = array("f", bytes(4 * n**3))
        for c, field in enumerate(texels):
            factor, = array("f", [head.rotation[c * bands + band] * head.unit])
            product = array("f", [factor * texel for texel in array("f", field)])
            total = array("f", map(add, total, product))
        values.extend(total)
    return values
