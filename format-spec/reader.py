#!/usr/bin/env python3
"""An independent reader of .flb files, written from SPEC.md alone; rule numbers (M1...) are its.

    reader.py FILE    verifies FILE and prints, as JSON, per species the xxh3-64 of its metadata, of its
                      medium's arrays and of every base, decoded: f32 little-endian (class: u8), in
                      [z][y][x] order, bases as [band][z][y][x].

Exit status 0 for a valid file, 1 for an invalid one, 2 usage, 4 input/output, 5 unsupported. Standard
library only; zstd pages need the package `zstandard`.
"""
import json
import struct
import sys
import unicodedata
from array import array
from decimal import Decimal

try:
    import zstandard
except ImportError:
    zstandard = None

UNSUPPORTED = (0, 1003, 1004, 2005, 2006, 3007)
ITEMS = ("density", "class", "leaf_area_density", "wood_area_density")
M64 = (1 << 64) - 1

class FlbError(Exception):
    def __init__(self, code, message):
        super().__init__(f"FLB-{code} {message}")
        self.code = code

def need(holds, code, message):
    if not holds:
        raise FlbError(code, message)

# --- xxh3-64, seed 0, default secret, inputs of 17 bytes and more ---------------------------------

SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221"
    "b8084674f743248ee03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb"
    "170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)
P32_1, P32_2, P32_3 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
P64_1, P64_2, P64_3 = 0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9
P64_4, P64_5 = 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5

def fold(a, b):
    product = a * b
    return (product & M64) ^ (product >> 64)

def avalanche(h):
    h ^= h >> 37
    h = h * 0x165667919E3779F9 & M64
    return h ^ (h >> 32)

def mix16(data, at, secret_at):
    a, b = struct.unpack_from("<QQ", data, at)
    x, y = struct.unpack_from("<QQ", SECRET, secret_at)
    return fold(a ^ x, b ^ y)

def xxh3(data):
    n = len(data)
    assert n > 16, "the format digests no shorter input"
    total = n * P64_1 & M64
    if n <= 128:
        for i in reversed(range((n - 1) // 32 + 1)):
            total += mix16(data, 16 * i, 32 * i) + mix16(data, n - 16 * (i + 1), 32 * i + 16)
        return avalanche(total & M64)
    if n <= 240:
        total += sum(mix16(data, 16 * i, 16 * i) for i in range(8))
        total = avalanche(total & M64)
        total += sum(mix16(data, 16 * i, 16 * (i - 8) + 3) for i in range(8, n // 16))
        return avalanche(total + mix16(data, n - 16, 136 - 17) & M64)
    acc = [P32_3, P64_1, P64_2, P64_3, P64_4, P32_2, P64_5, P32_1]
    keys = [struct.unpack_from("<8Q", SECRET, 8 * i) for i in range(17)]

    def accumulate(at, key):
        values = struct.unpack_from("<8Q", data, at)
        for i in range(8):
            k = values[i] ^ key[i]
            acc[i ^ 1] += values[i]
            acc[i] += (k & 0xFFFFFFFF) * (k >> 32)

    blocks = (n - 1) // 1024
    for block in range(blocks):
        for i in range(16):
            accumulate(block * 1024 + 64 * i, keys[i])
        for i in range(8):
            a = acc[i] & M64
            acc[i] = ((a ^ (a >> 47)) ^ keys[16][i]) * P32_1 & M64
    for i in range((n - 1 - 1024 * blocks) // 64):
        accumulate(blocks * 1024 + 64 * i, keys[i])
    accumulate(n - 64, struct.unpack_from("<8Q", SECRET, 192 - 64 - 7))
    last = struct.unpack_from("<8Q", SECRET, 11)
    for i in range(0, 8, 2):
        total += fold((acc[i] & M64) ^ last[i], (acc[i + 1] & M64) ^ last[i + 1])
    return avalanche(total & M64)

# --- BLAKE3, 256 bits, no key -----------------------------------------------------------------------

IV = (0x6A09E667, 0xBB67AE85, 0x3C6EF372, 0xA54FF53A, 0x510E527F, 0x9B05688C, 0x1F83D9AB, 0x5BE0CD19)
ROUNDS = [list(range(16))]
for _ in range(6):
    ROUNDS.append([ROUNDS[-1][i] for i in (2, 6, 3, 10, 7, 0, 4, 13, 1, 11, 12, 5, 9, 14, 15, 8)])
MIXES = [(0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15),
         (0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14)]
STEPS = [(a, b, c, d, order[2 * i], order[2 * i + 1])
         for order in ROUNDS for i, (a, b, c, d) in enumerate(MIXES)]
CHUNK_START, CHUNK_END, PARENT, ROOT = 1, 2, 4, 8

def compress(chain, words, counter, length, flags):
    v = [*chain, *IV[:4], counter & 0xFFFFFFFF, counter >> 32, length, flags]
    mask = 0xFFFFFFFF
    for a, b, c, d, x, y in STEPS:
        va = v[a] + v[b] + words[x] & mask
        vd = v[d] ^ va
        vd = (vd >> 16 | vd << 16) & mask
        vc = v[c] + vd & mask
        vb = v[b] ^ vc
        vb = (vb >> 12 | vb << 20) & mask
        va = va + vb + words[y] & mask
        vd ^= va
        vd = (vd >> 8 | vd << 24) & mask
        vc = vc + vd & mask
        vb ^= vc
        v[a], v[b], v[c], v[d] = va, (vb >> 7 | vb << 25) & mask, vc, vd
    return tuple(v[i] ^ v[i + 8] for i in range(8))

def blake3(data):
    def chunk(start, end, counter, root):
        chain = IV
        for at in range(start, max(end, start + 1), 64):
            block = data[at:min(at + 64, end)]
            flags = (CHUNK_START if at == start else 0)
            if at + 64 >= end:
                flags |= CHUNK_END | root
            words = struct.unpack("<16I", block.ljust(64, b"\0"))
            chain = compress(chain, words, counter, len(block), flags)
        return chain

    def tree(start, end, counter, root):
        if end - start <= 1024:
            return chunk(start, end, counter, root)
        left = 1 << ((end - start - 1) // 1024).bit_length() - 1  # chunks, a power of two
        middle = start + left * 1024
        words = tree(start, middle, counter, 0) + tree(middle, end, counter + left, 0)
        return compress(IV, words, 0, 64, PARENT | root)

    return struct.pack("<8I", *tree(0, len(data), 0, ROOT))

# --- sections 3 to 7: header, tables, pages ---------------------------------------------------------

def align(offset, step):
    return -(-offset // step) * step

class Section:
    def __init__(self, record):
        (self.kind, self.species, self.item, self.flags, self.data_offset, self.data_bytes,
         self.raw_bytes, self.table_offset, self.page_count, self.codec, self.threshold_bits,
         self.page_bytes, self.lattice, self.bands, self.units, self.reserved,
         self.table_digest) = struct.unpack("<4I4Q6I3Q", record)
        self.key = (self.kind, self.species, self.item)
        self.threshold = struct.unpack("<f", struct.pack("<I", self.threshold_bits))[0]
        self.known = self.kind in (1, 2, 3)
        self.pages = []

    def check(self):
        def field(holds, name):
            need(holds, 2007, f"section {self.key}: field {name}")

        need(self.reserved == 0, 1007, f"section {self.key}: reserved field")
        field(self.flags <= 3, "flags")
        field(16384 <= self.page_bytes <= 4194304 and self.page_bytes % 4096 == 0, "page_bytes")
        field(self.page_count > 0, "page_count")
        field(self.units > 0, "units")
        if not self.known:
            need(self.flags & 1 == 0, 2005, f"section {self.key}: required, but of unknown kind")
            return
        field(self.flags == 1, "flags")
        field(self.item < {1: 1, 2: 4, 3: 19}[self.kind], "item")
        codecs = {1: (5,), 2: (4,) if self.item == 1 else (3,), 3: (1, 2)}[self.kind]
        need(self.codec in codecs, 2006, f"section {self.key}: codec {self.codec}")
        # +0 to 2^96 are the bit patterns up to that of 2^96.
        field(self.threshold_bits <= (0x6F800000 if self.codec == 2 else 0), "threshold")
        if self.kind == 1:
            field(self.lattice == 0 and self.bands == 0, "lattice, bands")
            need(self.units <= 1048576, 1009, f"section {self.key}: metadata too long")
            return
        field(self.lattice in (16, 32, 64, 128, 256), "lattice")
        field(1 <= self.bands <= (16 if self.kind == 3 else 1), "bands")
        blocks = ((self.lattice - 2) // 3 + 1) ** 3
        field(self.units == (blocks if self.codec == 2 else self.lattice**3 * self.bands), "units")

class Page:
    def __init__(self, record, name):
        self.name = name
        (self.offset, self.stored_bytes, self.raw_bytes, self.first, self.count, self.compression,
         self.reserved, self.digest) = struct.unpack("<QIIQIIQQ", record)

    def check(self, section):
        need(self.reserved == 0, 1007, f"{self.name}: reserved field")
        need(1 <= self.raw_bytes <= section.page_bytes, 3004, f"{self.name}: payload size")
        need(self.compression in (0, 1), 3007, f"{self.name}: compression {self.compression}")
        plain = self.compression == 0
        fits = self.stored_bytes == self.raw_bytes if plain else 1 <= self.stored_bytes < self.raw_bytes
        need(fits, 3004, f"{self.name}: stored size")
        fits = self.count > 0
        if section.known:
            fits = fits and {1: self.raw_bytes == 4 * self.count, 2: self.raw_bytes >= 12 * self.count,
                5: self.raw_bytes == self.count,
            }.get(section.codec, self.count % 64 == 0 and self.raw_bytes >= self.count // 8)
        need(fits, 3005, f"{self.name}: number of units")

class File:
    """Levels header and tables of SPEC.md section 11."""

    def __init__(self, data):
        self.data = data
        self.read_header()
        self.read_contents()
        for section in self.sections:
            self.read_page_table(section)
        compressed = any(page.compression for s in self.sections for page in s.pages)
        need(self.required & 1 == int(compressed), 1010, "header: feature bit 0")
        self.join_species()

    def read_header(self):
        data = self.data
        need(len(data) >= 8, 1001, "file: too short")
        need(data[:8] == bytes.fromhex("89464C420D0A1A0A"), 1002, "header: magic")
        need(len(data) >= 128, 1001, "file: too short")
        (major, minor, size, self.required, _, length, contents, contents_bytes, count, reserved_60,
         self.contents_digest, self.tables_end, self.root, reserved_112, digest) = struct.unpack(
             "<HHIQQQQQIIQQ32sQQ", data[8:128])
        self.version = (major, minor)
        need(major == 0, 1003, f"header: version {major}.{minor}")
        need(size == 128, 1006, f"header: size {size}")
        need(xxh3(data[:120]) == digest, 1005, "header: digest")
        need(self.required & ~1 == 0, 1004, f"header: required features {self.required:#x}")
        need(reserved_60 == 0 and reserved_112 == 0, 1007, "header: reserved field")
        need(length == len(data), 1008, f"header: file length {length}, it has {len(data)}")
        need(contents == 128 and count > 0, 2001, "header: offset or number of sections")
        need(count <= 65536, 1009, "header: number of sections")
        need(contents_bytes == 96 * count, 2001, "header: size of the table of contents")
        self.contents_end = 128 + contents_bytes
        need(self.tables_end >= self.contents_end, 2001, "header: tables_end")
        need((self.tables_end - self.contents_end) // 48 <= 4194304, 1009, "header: number of pages")
        need(self.tables_end <= length, 2001, "header: tables_end")

    def read_contents(self):
        contents = self.data[128:self.contents_end]
        need(xxh3(contents) == self.contents_digest, 2002, "table of contents: digest")
        self.sections = []
        table_end, data_end, previous = self.contents_end, self.tables_end, None
        for at in range(0, len(contents), 96):
            section = Section(contents[at:at + 96])
            if previous is not None:
                need(section.key != previous, 2004, f"section {section.key}: twice")
                need(section.key > previous, 2003, f"section {section.key}: out of order")
            section.check()
            need(section.table_offset == table_end, 3001, f"section {section.key}: page table's place")
            table_end += 48 * section.page_count
            need(table_end <= self.tables_end, 3001, f"section {section.key}: page table's end")
            need(section.data_offset == align(data_end, 64), 2009, f"section {section.key}: place")
            data_end = section.data_offset + section.data_bytes
            need(data_end <= len(self.data), 2007, f"section {section.key}: field data_bytes")
            self.sections.append(section)
            previous = section.key
        need(table_end == self.tables_end, 2001, "header: tables_end")
        need(data_end == len(self.data), 1008, "header: file length")

    def read_page_table(self, section):
        table = self.data[section.table_offset:section.table_offset + 48 * section.page_count]
        need(xxh3(table) == section.table_digest, 3002, f"section {section.key}: page table's digest")
        end, units, raw_bytes = section.data_offset, 0, 0
        for i in range(section.page_count):
            page = Page(table[48 * i:48 * i + 48], f"page {i} of section {section.key}")
            need(page.offset == align(end, 16), 3003, f"{page.name}: place")
            page.check(section)
            need(page.first == units, 3005, f"{page.name}: first unit")
            units, raw_bytes = units + page.count, raw_bytes + page.raw_bytes
            end = page.offset + page.stored_bytes
            section.pages.append(page)
        sums = (units, raw_bytes, end - section.data_offset)
        found = (section.units, section.raw_bytes, section.data_bytes)
        need(sums == found, 3006, f"section {section.key}: sums {found}, pages give {sums}")

    def join_species(self):
        self.species = []
        for section in filter(lambda s: s.known, self.sections):
            if section.kind == 1:
                need(section.species == len(self.species), 2008, f"species {len(self.species)}: metadata")
                text = b"".join(self.payload(section, i) for i in range(len(section.pages)))
                meta = read_metadata(text)
                names = [other["meta"]["name"] for other in self.species]
                need(meta["name"] not in names, 5004, f"species {section.species}: name")
                self.species.append({"meta": meta, "text": text, "medium": {}, "bases": {}})
                continue
            need(section.species < len(self.species), 2008, f"species {section.species}: metadata")
            owner = self.species[section.species]
            need(section.lattice == owner["meta"]["grid"]["lattice"], 2007, f"{section.key}: lattice")
            if section.kind == 3:
                need(section.bands == len(owner["meta"]["optics"]), 2007, f"{section.key}: bands")
            owner["medium" if section.kind == 2 else "bases"][section.item] = section
        need(self.species, 2008, "species 0: metadata")
        for i, owner in enumerate(self.species):
            need(len(owner["medium"]) == 4 and owner["bases"], 2008, f"species {i}: medium or bases")

    def payload(self, section, index):
        page = section.pages[index]
        stored = self.data[page.offset:page.offset + page.stored_bytes]
        place = struct.pack("<4I", *section.key, index)
        need(xxh3(place + stored) == page.digest, 4001, f"{page.name}: digest")
        return stored if page.compression == 0 else decompress(stored, page)

    def check_pages(self):
        for section in self.sections:
            for i in range(len(section.pages)):
                self.payload(section, i)
        end = self.tables_end
        for page in (page for section in self.sections for page in section.pages):
            need(not any(self.data[end:page.offset]), 4004, f"padding at byte {end}")
            end = page.offset + page.stored_bytes
        need(blake3(self.data[:80] + self.data[128:]) == self.root, 4005, "header: root")

def decompress(stored, page):
    """M25: one frame that declares its size; the header is read here, RFC 8878 section 3.1.1.1."""
    def frame(holds, reason):
        need(holds, 4002, f"{page.name}: zstd frame {reason}")

    frame(len(stored) >= 6 and stored[:4] == b"\x28\xb5\x2f\xfd", "has no magic")
    descriptor, at = stored[4], 5
    frame(descriptor & 0b1011 == 0, "sets its reserved bit or wants a dictionary")
    single = descriptor & 0b100000 != 0
    if not single:
        base = 1 << 10 + (stored[5] >> 3)
        frame(base + base // 8 * (stored[5] & 7) <= 8388608, "wants too large a window")
        at = 6
    size = (1 if single else 0, 2, 4, 8)[descriptor >> 6]
    declared = int.from_bytes(stored[at:at + size], "little") + (256 if size == 2 else 0)
    frame(size > 0 and declared == page.raw_bytes, "declares another size, or none")
    need(zstandard is not None, 0, "the file has zstd pages: install the Python package zstandard")
    engine = zstandard.ZstdDecompressor(max_window_size=8388608).decompressobj()
    try:
        payload = engine.decompress(stored)
    except zstandard.ZstdError as error:
        raise FlbError(4002, f"{page.name}: {error}") from error
    frame(engine.eof and not engine.unused_data, "does not end with the page")
    need(len(payload) == page.raw_bytes, 4003, f"{page.name}: payload size")
    return payload

# --- section 9: metadata ----------------------------------------------------------------------------

def canonical(value, depth=1):
    need(depth <= 32 or not isinstance(value, (list, dict)), 5002, "metadata: nested too deep")
    if isinstance(value, list):
        return "[" + ",".join(canonical(item, depth + 1) for item in value) + "]"
    if isinstance(value, dict):
        keys = sorted(value, key=lambda key: key.encode("utf-16-be", "surrogatepass"))
        return "{" + ",".join(canonical(k) + ":" + canonical(value[k], depth + 1) for k in keys) + "}"
    if value is None or isinstance(value, (str, bool)):
        return json.dumps(value, ensure_ascii=False)  # escapes strings as M31 wants
    if value % 1 == 0:
        need(abs(value) <= 1 << 53, 5002, "metadata: number over 2^53")
        return str(int(value))
    if abs(value) >= 1e-6:
        return format(Decimal(repr(value)), "f")  # repr gives the fewest digits
    mantissa, exponent = repr(value).split("e")
    return f"{mantissa}e{int(exponent)}"

def read_metadata(text):
    def constant(name):
        raise ValueError(name)

    try:
        value = json.loads(text.decode("utf-8"), parse_constant=constant)
    except (ValueError, RecursionError) as error:
        raise FlbError(5001, f"metadata: {error}") from error
    need(canonical(value).encode("utf-8", "surrogatepass") == text, 5002, "metadata: not canonical")
    try:
        check_metadata(value)
    except (KeyError, TypeError, AttributeError) as error:
        raise FlbError(5003, f"metadata: {error!r}") from error
    return value

def check_metadata(meta):
    def rule(holds, field):
        need(holds, 5003, f"metadata: {field}")

    def members(value, *names):
        rule(isinstance(value, dict) and set(value) == set(names), f"members {names}")
        return [value[name] for name in names]

    def real(value, low, high, field):
        rule(type(value) in (int, float) and low <= value <= high, field)

    def text(value, field, holds):
        rule(isinstance(value, str) and holds(value), field)

    def is_name(value):
        plain = not any(c in "/\\" or unicodedata.category(c) == "Cc" for c in value)
        return plain and 1 <= len(value.encode()) <= 255 and value not in (".", "..")

    def point(value, field):
        rule(isinstance(value, list) and len(value) == 3, field)
        for coordinate in value:
            real(coordinate, -1e9, 1e9, field)

    text(meta["name"], "name", is_name)
    text(meta["model"], "model", lambda model: model == "paper")
    text(meta["tool"], "tool", lambda tool: tool != "")
    rule(isinstance(meta["settings"], dict), "settings")
    lattice, origin, spacing = members(meta["grid"], "lattice", "origin_m", "spacing_m")
    rule(type(lattice) is int and lattice in (16, 32, 64, 128, 256), "grid.lattice")
    point(origin, "grid.origin_m")
    real(spacing, 1e-9, 1e9, "grid.spacing_m")
    low, high = members(meta["bounds_m"], "min", "max")
    point(low, "bounds_m.min")
    point(high, "bounds_m.max")
    rule(all(a <= b for a, b in zip(low, high)), "bounds_m")
    rule(isinstance(meta["optics"], list) and 1 <= len(meta["optics"]) <= 16, "optics")
    names = set()
    for title, *classes in (members(band, "name", "leaf", "wood") for band in meta["optics"]):
        text(title, "optics.name", lambda name: is_name(name) and name not in names)
        names.add(title)
        for sigma_a, g in (members(c, "sigma_a", "g") for c in classes):
            real(sigma_a, 0, 1, "optics.sigma_a")
            real(g, -1, 1, "optics.g")
    counts = members(meta["triangles"], "total", "leaf", "wood")
    rule(all(type(n) is int and n >= 0 for n in counts) and counts[1] + counts[2] <= counts[0], "triangles")
    rule(isinstance(meta["sources"], list), "sources")
    for title, blake in (members(source, "name", "blake3") for source in meta["sources"]):
        text(title, "sources.name", is_name)
        text(blake, "sources.blake3", lambda b: len(b) == 64 and set(b) <= set("0123456789abcdef"))

# --- section 8: codecs ------------------------------------------------------------------------------

def floats(data):
    values = array("f", data)
    if sys.byteorder == "big":
        values.byteswap()
    return values

def digest(values):
    values = values[:]
    if sys.byteorder == "big":
        values.byteswap()
    return f"{xxh3(values.tobytes()):016x}"

def check_values(values, data, page):
    fits = all(-(2.0**96) <= value <= 2.0**96 for value in values)
    need(fits and b"\0\0\0\x80" not in {data[i:i + 4] for i in range(0, len(data), 4)}, 5006,
         f"{page.name}: a number is not finite, over 2^96, or -0")

LINES = [(step, [i for i in range(64) if i // step % 4 == 0]) for step in (1, 4, 16)]  # x, y, z

def inverse_haar(k):
    for step, starts in LINES:
        s = array("f", [k[i] + k[i + step] for i in starts])  # array("f") rounds to binary32
        t = array("f", [k[i] - k[i + step] for i in starts])
        out = array("f", bytes(256))
        for i, a, b in zip(starts, s, t):
            c, d = k[i + 2 * step], k[i + 3 * step]
            out[i], out[i + step], out[i + 2 * step], out[i + 3 * step] = a + c, a - c, b + d, b - d
        k = out
    return k

def decode_blocks(file, section):
    n, bands = section.lattice, section.bands
    edge = (n - 2) // 3 + 1
    field = array("f", bytes(4 * n**3 * bands))
    limit = array("f", [section.threshold * (18.0 if section.item == 0 else 1.0)])[0]
    for index, page in enumerate(section.pages):
        data = file.payload(section, index)
        masks = struct.unpack_from(f"<{page.count}Q", data)
        offsets = struct.unpack_from(f"<{page.count}I", data, 8 * page.count)
        kept = 0
        for mask, offset in zip(masks, offsets):
            need(offset == kept, 5005, f"{page.name}: index of a block")
            kept += mask.bit_count()
        head = 12 * page.count
        need(len(data) == head + 4 * kept * bands, 4003, f"{page.name}: payload size")
        values = floats(data[head:])
        check_values(values, data[head:], page)
        for b, mask, at in zip(range(page.first, page.first + page.count), masks, offsets):
            bits = [c for c in range(64) if mask >> c & 1]
            blocks = [array("f", bytes(256)) for _ in range(bands)]
            for c in bits:
                group = values[at * bands:at * bands + bands]
                need(any(abs(v) > (limit if c else 0) for v in group), 5007, f"{page.name}: coefficient {c}")
                for band, value in enumerate(group):
                    blocks[band][c] = value
                at += 1
            bx, by, bz = b % edge, b // edge % edge, b // edge**2
            own = [min(4 if p == edge - 1 else 3, n - 3 * p) for p in (bx, by, bz)]
            for band in range(bands):
                texels = inverse_haar(blocks[band]) if bits else blocks[band]
                for z in range(own[2]):
                    for y in range(own[1]):
                        to = (((band * n + 3 * bz + z) * n) + 3 * by + y) * n + 3 * bx
                        field[to:to + own[0]] = texels[16 * z + 4 * y:16 * z + 4 * y + own[0]]
    return field

def decode_base(file, section):
    if section.codec == 2:
        return decode_blocks(file, section)
    field = array("f")
    for index, page in enumerate(section.pages):
        data = file.payload(section, index)
        values = floats(data)
        check_values(values, data, page)
        field.extend(values)
    return field

def decode_sparse(file, section):
    width = 4 if section.codec == 3 else 1
    result = array("f" if width == 4 else "B")
    for index, page in enumerate(section.pages):
        data = file.payload(section, index)
        groups = page.count // 64
        masks = struct.unpack_from(f"<{groups}Q", data)
        kept = sum(mask.bit_count() for mask in masks)
        need(len(data) == 8 * groups + width * kept, 4003, f"{page.name}: payload size")
        stream = floats(data[8 * groups:]) if width == 4 else array("B", data[8 * groups:])
        fits = all(0 < v <= 2.0**96 if width == 4 else v in (1, 2) for v in stream)
        need(fits, 5006, f"{page.name}: a stored value")
        values = iter(stream)
        result.extend(next(values) if mask >> i & 1 else 0 for mask in masks for i in range(64))
    return result

def decode_medium(file, sections):
    density, classes = decode_sparse(file, sections[0]), decode_sparse(file, sections[1])
    for site, (d, c) in enumerate(zip(density, classes)):
        need(d <= 1 and (d == 0) == (c == 0), 5008, f"site {site}: class {c}, density {d}")
    return [density, classes, decode_sparse(file, sections[2]), decode_sparse(file, sections[3])]

def read(data):
    """Everything in a file, checked at level decode, as a summary with digests."""
    file = File(data)
    file.check_pages()
    summary = []
    for owner in file.species:
        medium = decode_medium(file, owner["medium"])
        bases = {item: decode_base(file, section) for item, section in sorted(owner["bases"].items())}
        summary.append({"name": owner["meta"]["name"], "metadata": f"{xxh3(owner['text']):016x}",
            "medium": {name: digest(values) for name, values in zip(ITEMS, medium)},
            "bases": {item: digest(values) for item, values in bases.items()}})
    return {"format_version": "%d.%d" % file.version, "root": file.root.hex(), "species": summary}

def main(arguments):
    if len(arguments) != 2:
        print("usage: reader.py FILE", file=sys.stderr)
        return 2
    try:
        with open(arguments[1], "rb") as handle:
            data = handle.read()
        print(json.dumps(read(data), indent=1))
    except OSError as error:
        print(error, file=sys.stderr)
        return 4
    except FlbError as error:
        print(error, file=sys.stderr)
        return 5 if error.code in UNSUPPORTED else 1
    return 0

if __name__ == "__main__":
    sys.exit(main(sys.argv))
