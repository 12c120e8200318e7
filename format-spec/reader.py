#!/usr/bin/env python3
"""An independent reader of .flb files, written from SPEC.md alone; rule numbers (M1...) are its.

    reader.py FILE    verifies FILE and prints, as JSON, per species the xxh3-64 of its metadata, of its
                      medium's arrays and of every base, decoded: f32 little-endian (class: u8), in
                      [z][y][x] order, bases as [band][z][y][x].

Exit status 0 for a valid file, 1 for an invalid one, 2 usage, 4 input/output, 5 unsupported. Standard
library only, with blocks.py, faults.py, hashes.py, metadata.py and suns.py beside this file; zstd pages need the package
`zstandard`.
"""
import json, struct, sys
from array import array

import blocks
from faults import FlbError, need
from hashes import blake3, xxh3
from metadata import bands_of, check_materials, items_of, needs_all, read_metadata

try:
    import zstandard
except ImportError:
    zstandard = None

UNSUPPORTED = (0, 1003, 1004, 2005, 2006, 3007)

# --- sections 3 to 7: header, tables, pages ---------------------------------------------------------
class Section:
    def __init__(self, record, draft):
        (self.kind, self.species, self.item, self.flags, self.data_offset, self.data_bytes, self.raw_bytes,
         self.table_offset, self.page_count, self.codec, self.threshold_bits, self.page_bytes, self.lattice,
         self.bands, self.units, self.reserved, self.table_digest) = struct.unpack("<4I4Q6I3Q", record)
        self.key = (self.kind, self.species, self.item)
        self.threshold = struct.unpack("<f", struct.pack("<I", self.threshold_bits))[0]
        self.known = 1 <= self.kind <= (3 if draft else 6)
        self.pages = []
    def check(self):
        def field(holds, name):
            need(holds, 2007, f"section {self.key}: field {name}")
        need(self.reserved == 0, 1007, f"section {self.key}: reserved field")
        field(self.kind > 0, "kind")
        field(self.flags <= 3, "flags")
        field(20480 <= self.page_bytes <= 4194304 and self.page_bytes % 4096 == 0, "page_bytes")
        field(self.page_count > 0 and self.units > 0, "page_count or units")
        if not self.known:
            need(self.flags & 1 == 0, 2005, f"section {self.key}: required, but of unknown kind")
            return
        field(self.flags == 1, "flags")
        field(self.item < {1: 1, 2: 6, 4: 2}.get(self.kind, 256), "item")
        codecs = {1: (5,), 2: (4,) if self.item == 1 else (3,), 3: (1, 2, 6), 4: (9 + self.item,),
                  5: (11,), 6: (7, 8)}[self.kind]
        need(self.codec in codecs, 2006, f"section {self.key}: codec {self.codec}")
        field(self.threshold_bits <= (0x6F800000 if self.codec == 2 else 0), "threshold")  # +0 to 2^96
        if self.kind == 1:
            field(self.lattice == 0 and self.bands == 0, "lattice, bands")
            need(self.units <= 1048576, 1009, f"section {self.key}: metadata too long")
            return
        field(self.lattice in (16, 32, 64, 128, 256), "lattice")
        field(1 <= self.bands <= (1 if self.kind in (2, 4) else 64), "bands")
        field(self.units in self.units_of_codec(), "units")
        field(self.kind != 6 or self.raw_bytes <= 1 << 28, "raw_bytes")
    def units_of_codec(self):
        n, bands = self.lattice, self.bands
        least, most = {2: (((n - 2) // 3 + 1) ** 3,) * 2, 7: (1, (n // 4) ** 3), 8: (1, (n // 4) ** 3),
                       9: ((n // 4) ** 3 // 8,) * 2, 10: (68, 16388),
                       11: (1, 36 + 4 * bands**2 + 5 * bands * ((n // 4) ** 3 + (n // 16) ** 3)),
                       }.get(self.codec, (n**3 * bands,) * 2)
        return range(least, most + 1)

class Page:
    def __init__(self, record, name):
        self.name = name
        (self.offset, self.stored_bytes, self.raw_bytes, self.first, self.count, self.compression,
         self.priority_bits, self.reserved, self.digest) = struct.unpack("<QIIQIIIIQ", record)
        self.stored = (self.offset, self.stored_bytes, self.raw_bytes, self.compression)
    def check(self, section, draft):
        need(self.reserved == 0 and not (draft and self.priority_bits), 1007, f"{self.name}: reserved field")
        need(self.priority_bits <= 0x6F800000, 3008, f"{self.name}: priority")  # +0 to 2^96
        need(1 <= self.raw_bytes <= section.page_bytes, 3004, f"{self.name}: payload size")
        need(self.compression in (0, 1), 3007, f"{self.name}: compression {self.compression}")
        sizes = range(1, self.raw_bytes) if self.compression else [self.raw_bytes]
        need(self.stored_bytes in sizes, 3004, f"{self.name}: stored size")
        sparse = lambda width: self.count % 64 == 0 and 0 <= self.raw_bytes - self.count // 8 <= width * self.count
        words = self.raw_bytes % 4 == 0 and self.raw_bytes <= -(-761 * section.bands * self.count // 32) * 4
        fits = {1: self.raw_bytes == 4 * self.count, 3: sparse(4), 4: sparse(1), 7: words, 8: words,
                2: 12 * self.count <= self.raw_bytes <= (12 + 256 * section.bands) * self.count,
                6: self.raw_bytes == 2 * self.count}
        fits = self.count > 0 and (not section.known or fits.get(section.codec, self.raw_bytes == self.count))
        need(fits, 3005, f"{self.name}: number of units")

class File:
    """Levels header and tables of SPEC.md section 11."""
    def __init__(self, data):
        self.data = data
        self.read_header()
        self.read_contents()
        self.own = set()
        for section in self.sections:
            self.read_page_table(section)
        raw = [sum(s.raw_bytes for s in self.sections if s.kind <= kind) for kind in (1, 1 << 32)]
        need(raw[0] <= 1 << 23 and raw[1] <= 1 << 40, 1009, "sizes of all metadata, or of all payloads")
        compressed = any(page.compression for s in self.sections for page in s.pages)
        need(self.required & 1 == compressed, 1010, "header: feature bit 0")
        halves = any(s.kind == 3 and s.codec == 6 for s in self.sections)
        need(self.required >> 2 & 1 == halves, 1010, "header: feature bit 2")
        mapped = any(s.kind == 4 and s.known for s in self.sections)
        need(self.required >> 3 & 1 == mapped, 1010, "header: feature bit 3")
        self.join_species()
    def read_header(self):
        data = self.data
        need(len(data) >= 8, 1001, "file: too short")
        need(data[:8] == bytes.fromhex("89464C420D0A1A0A"), 1002, "header: magic")
        need(len(data) >= 128, 1001, "file: too short")
        (major, minor, size, self.required, _, length, contents, contents_bytes, count, reserved_60,
         self.contents_digest, self.tables_end, self.root, reserved_112, digest) = struct.unpack(
             "<HHIQQQQQIIQQ32sQQ", data[8:128])
        self.version, self.draft = (major, minor), major == 0
        need(major in (0, 1), 1003, f"header: version {major}.{minor}")
        need(size == 128, 1006, f"header: size {size}")
        need(xxh3(data[:120]) == digest, 1005, "header: digest")
        need(self.required & ~(7 if self.draft else 31) == 0, 1004, f"header: required features {self.required:#x}")
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
        table_end, data_end, previous = self.contents_end, self.tables_end, ()
        for at in range(0, len(contents), 96):
            section = Section(contents[at:at + 96], self.draft)
            need(section.key != previous, 2004, f"section {section.key}: twice")
            need(section.key > previous, 2003, f"section {section.key}: out of order")
            section.check()
            need(section.table_offset == table_end, 3001, f"section {section.key}: page table's place")
            table_end += 48 * section.page_count
            need(table_end <= self.tables_end, 3001, f"section {section.key}: page table's end")
            shared = section.data_bytes == 0 and not self.draft
            place = 0 if shared else -(-data_end // 64) * 64
            need(section.data_offset == place, 2009, f"section {section.key}: place")
            data_end = data_end if shared else section.data_offset + section.data_bytes
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
            page.own = page.offset == -(-end // 16) * 16 and section.data_offset > 0
            need(page.own or page.stored in self.own, 3003, f"{page.name}: place")
            page.check(section, self.draft)
            need(page.first == units, 3005, f"{page.name}: first unit")
            units, raw_bytes = units + page.count, raw_bytes + page.raw_bytes
            if page.own:
                end = page.offset + page.stored_bytes
            if not self.draft:
                self.own.add(page.stored)
            section.pages.append(page)
        sums = (units, raw_bytes, end - section.data_offset)
        need(sums == (section.units, section.raw_bytes, section.data_bytes), 3006, f"{section.key}: sums")
    def join_species(self):
        self.species = []
        for section in self.sections:
            if not section.known:
                has = section.species < len(self.species) or section.species == 0xFFFFFFFF
                need(has, 2007, f"{section.key}: species")
                continue
            if section.kind == 1:
                need(section.species == len(self.species), 2008, f"species {len(self.species)}: metadata")
                text = self.all_payloads(section)
                meta = read_metadata(text)
                names = [other["meta"]["name"] for other in self.species]
                need(meta["name"] not in names, 5004, f"species {section.species}: name")
                self.species.append({"meta": meta, "text": text, 2: {}, 3: {}, 4: {}, 5: {}, 6: {}})
                continue
            need(section.species < len(self.species), 2008, f"species {section.species}: metadata")
            owner = self.species[section.species]
            media, bases = items_of(owner["meta"])
            need(section.item < {2: media, 4: 2}.get(section.kind, bases), 2007, f"{section.key}: item")
            need(section.lattice == owner["meta"]["grid"]["lattice"], 2007, f"{section.key}: lattice")
            if section.kind in (3, 5, 6):
                need(section.bands == len(bands_of(owner["meta"])), 2007, f"{section.key}: bands")
            if section.kind in (3, 5):
                listed = section.item in owner["meta"].get("left_out", {}).get("bases", [])
                need(not listed, 5009, f"{section.key}: was left out")
            self.join_blocks(section, owner)
            owner[section.kind][section.item] = section
        need(self.species, 2008, "species 0: metadata")
        for i, owner in enumerate(self.species):
            media, bases = items_of(owner["meta"])
            least = bases if needs_all(owner["meta"]) else 1
            need(len(owner[2]) == media, 2008, f"species {i}: medium")
            need(set(owner[5]) <= set(owner[6]), 2008, f"species {i}: detail")
            need(len(owner[3] | owner[6]) >= least, 2008, f"species {i}: bases")
        physical = any("light" in owner["meta"] for owner in self.species)
        need(self.required >> 1 & 1 == physical, 1010, "header: feature bit 1")
        leaning = any("light" in owner["meta"] and "leaning" in owner["meta"]["light"]["suns"] for owner in self.species)
        need(self.required >> 4 & 1 == leaning, 1010, "header: feature bit 4")
        for owner in self.species:
            check_materials(owner["meta"])
    def join_blocks(self, section, owner):
        """M55, as far as the sections before this one tell."""
        if section.kind == 4:
            need(not owner[3], 2007, f"{section.key}: beside bases of kind 3")
            need(section.item == 0 or 0 in owner[4], 2008, f"{section.key}: block map")
        if section.kind == 5:
            need(0 in owner[4], 2008, f"{section.key}: block map")
        if section.kind == 6:
            need(section.item in owner[5], 2008, f"{section.key}: averages")
            need((section.codec == 7) == (1 in owner[4]), 2007, f"{section.key}: codec or class tables")
            for other in owner[6].values():
                same = (section.codec, section.units) == (other.codec, other.units)
                need(same, 2007, f"{section.key}: codec or units, unlike {other.key}")
    def all_payloads(self, section):
        return b"".join(self.payload(section, i) for i in range(len(section.pages)))
    def payload(self, section, index):
        page = section.pages[index]
        stored = self.data[page.offset:page.offset + page.stored_bytes]
        place = struct.pack("<4I", *section.key, index)
        need(xxh3(place + stored) == page.digest, 4001, f"{page.name}: digest")
        return stored if page.compression == 0 else decompress(stored, page)
    def check_pages(self):
        pages = [(section, i) for section in self.sections for i in range(len(section.pages))]
        for section, i in pages:
            self.payload(section, i)
        end = self.tables_end
        for page in filter(lambda page: page.own, (section.pages[i] for section, i in pages)):
            need(not any(self.data[end:page.offset]), 4004, f"padding at byte {end}")
            end = page.offset + page.stored_bytes
        need(blake3(self.data[:80] + self.data[128:]) == self.root, 4005, "header: root")
def decompress(stored, page):
    """M25: one frame that declares its size; the header is read here, RFC 8878 section 3.1.1.1."""
    def frame(holds, reason):
        need(holds, 4002, f"{page.name}: zstd frame {reason}")
    frame(len(stored) >= 6 and stored[:4] == b"\x28\xb5\x2f\xfd", "has no magic")
    descriptor = stored[4]
    frame(descriptor & 0b1011 == 0, "sets its reserved bit or wants a dictionary")
    single = descriptor & 0b100000 != 0
    if not single:
        base = 1 << 10 + (stored[5] >> 3)
        frame(base + base // 8 * (stored[5] & 7) <= 8388608, "wants too large a window")
    at, size = 5 if single else 6, (1 if single else 0, 2, 4, 8)[descriptor >> 6]
    declared = int.from_bytes(stored[at:at + size], "little") + (256 if size == 2 else 0)
    frame(size > 0 and declared == page.raw_bytes, "declares another size, or none")
    need(zstandard is not None, 0, "the file has zstd pages: install the Python package zstandard")
    engine = zstandard.ZstdDecompressor(max_window_size=8388608).decompressobj()
    try:
        payload = engine.decompress(stored)
    except zstandard.ZstdError as error:
        raise FlbError(4002, f"{page.name}: {error}") from error
    frame(engine.eof and not engine.unused_data, "does not end with the page")
    frame(len(payload) == page.raw_bytes, "gives another size")
    return payload

# --- section 8: codecs ------------------------------------------------------------------------------
def floats(data, width=4):
    return array("f", struct.unpack(f"<{len(data) // width}{'f' if width == 4 else 'e'}", data))
def digest(values):
    return f"{xxh3(struct.pack(f'<{len(values)}{values.typecode}', *values)):016x}"
def check_values(data, page, width=4):
    values = floats(data, width)
    negative_zero = b"\0\0\0\x80"[-width:] in {data[i:i + width] for i in range(0, len(data), width)}
    need(not negative_zero and all(abs(value) <= 2.0**96 for value in values), 5006, f"{page.name}: a number is not finite, over 2^96, or -0")
    return values
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
def decode_blocks(file, section, ambient):
    n, bands = section.lattice, section.bands
    edge = (n - 2) // 3 + 1
    field = array("f", bytes(4 * n**3 * bands))
    limit = array("f", [section.threshold * (ambient if section.item == 0 else 1.0)])[0]
    for index, page in enumerate(section.pages):
        data = file.payload(section, index)
        masks = struct.unpack_from(f"<{page.count}Q", data)
        offsets = struct.unpack_from(f"<{page.count}I", data, 8 * page.count)
        kept = 0
        for mask, offset in zip(masks, offsets):
            need(offset == kept, 5005, f"{page.name}: index of a block")
            kept += mask.bit_count()
        need(len(data) == 12 * page.count + 4 * kept * bands, 4003, f"{page.name}: payload size")
        values = check_values(data[12 * page.count:], page)
        for b, mask, at in zip(range(page.first, page.first + page.count), masks, offsets):
            bits = [c for c in range(64) if mask >> c & 1]
            coded = [array("f", bytes(256)) for _ in range(bands)]
            for at, c in enumerate(bits, at):
                group = values[at * bands:at * bands + bands]
                need(any(abs(v) > (limit if c else 0) for v in group), 5007, f"{page.name}: coefficient {c}")
                for band, value in enumerate(group):
                    coded[band][c] = value
            bx, by, bz = b % edge, b // edge % edge, b // edge**2
            own = [min(4 if p == edge - 1 else 3, n - 3 * p) for p in (bx, by, bz)]
            for band in range(bands):
                texels = inverse_haar(coded[band]) if bits else coded[band]
                for z in range(own[2]):
                    for y in range(own[1]):
                        to = (((band * n + 3 * bz + z) * n) + 3 * by + y) * n + 3 * bx
                        field[to:to + own[0]] = texels[16 * z + 4 * y:16 * z + 4 * y + own[0]]
    return field
def decode_near(file, owner):
    """The bases of kinds 5 and 6, by index; what they share is checked before any."""
    if not owner[4]:
        return {}
    where, classes = owner[4][0], owner[4].get(1)
    near = blocks.Map(file.all_payloads(where), where.lattice, f"section {where.key}")
    tables = blocks.read_classes(file.all_payloads(classes), f"section {classes.key}") if classes else None
    for detail in owner[6].values():
        need(detail.units == len(near.stored), 5014, f"section {detail.key}: units")
    bases = {}
    for item, detail in owner[6].items():
        averages = owner[5][item]
        pages = [(page.name, page.first, page.count, lambda i=i: file.payload(detail, i))
                 for i, page in enumerate(detail.pages)]
        bases[item] = digest(blocks.decode(file.all_payloads(averages), f"section {averages.key}", near,
                                           detail.bands, detail.codec, tables, pages))
    return bases
def decode_base(file, section, ambient):
    if section.codec == 2:
        return decode_blocks(file, section, ambient)
    field = array("f")
    for index, page in enumerate(section.pages):
        field.extend(check_values(file.payload(section, index), page, 4 if section.codec == 1 else 2))
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
AREAS = ("leaf_area_density", "wood_area_density", "leaf_extinction", "wood_extinction")
def read(data):
    """Everything in a file, checked at level decode, as a summary with digests."""
    file = File(data)
    file.check_pages()
    summary = []
    for owner in file.species:
        media, ambient = items_of(owner["meta"])[0], 18.0 if owner["meta"]["model"] == "paper" else 1.0
        density, classes = (decode_sparse(file, owner[2][item]) for item in range(2))
        for site, (d, c) in enumerate(zip(density, classes)):
            need(d <= 1 and (d == 0) == (c == 0), 5008, f"site {site}: class {c}, density {d}")
        areas = [decode_sparse(file, owner[2][item]) for item in range(2, media)]
        summary.append({
            "name": owner["meta"]["name"],
            "metadata": f"{xxh3(owner['text']):016x}",
            "medium": {"density": digest(density), "class": digest(classes),
                       **dict(zip(AREAS, map(digest, areas)))},
            "bases": {i: digest(decode_base(file, base, ambient)) for i, base in owner[3].items()}
                     | decode_near(file, owner),
        })
    return {"format_version": "%d.%d" % file.version, "root": file.root.hex(), "species": summary}
def main(arguments):
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        with open(arguments[1], "rb") as handle:
            print(json.dumps(read(handle.read()), indent=1))
    except (OSError, FlbError) as error:
        print(error, file=sys.stderr)
        return 4 if isinstance(error, OSError) else 5 if error.code in UNSUPPORTED else 1
    return 0

if __name__ == "__main__":
    sys.exit(main(sys.argv))
