"""The two hashes of .flb files (SPEC.md section 6), for reader.py: bytes to xxh3-64, bytes to BLAKE3."""
import struct

M64 = (1 << 64) - 1
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
    return (a * b & M64) ^ (a * b >> 64)
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
            acc[i] = (acc[i] ^ (acc[i] & M64) >> 47 ^ keys[16][i]) * P32_1 & M64
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
def compress(chain, words, counter, length, flags):
    v = [*chain, *IV[:4], counter & 0xFFFFFFFF, counter >> 32, length, flags]
    mask = 0xFFFFFFFF
    for a, b, c, d, x, y in STEPS:
        va = v[a] + v[b] + words[x] & mask
        vd = (v[d] ^ va) * 0x100000001 >> 16 & mask  # 32 bits rotated right by 16
        vc = v[c] + vd & mask
        vb = (v[b] ^ vc) * 0x100000001 >> 12 & mask
        va = va + vb + words[y] & mask
        vd = (vd ^ va) * 0x100000001 >> 8 & mask
        vc = vc + vd & mask
        vb = (vb ^ vc) * 0x100000001 >> 7 & mask
        v[a], v[b], v[c], v[d] = va, vb, vc, vd
    return tuple(v[i] ^ v[i + 8] for i in range(8))
def blake3(data):
    def chunk(start, end, counter, root):
        chain = IV
        for at in range(start, max(end, start + 1), 64):
            block = data[at:min(at + 64, end)]
            flags = (1 if at == start else 0) | (2 | root if at + 64 >= end else 0)  # first, last, root
            words = struct.unpack("<16I", block.ljust(64, b"\0"))
            chain = compress(chain, words, counter, len(block), flags)
        return chain
    def tree(start, end, counter, root):
        if end - start <= 1024:
            return chunk(start, end, counter, root)
        left = 1 << ((end - start - 1) // 1024).bit_length() - 1  # chunks, a power of two
        middle = start + left * 1024
        words = tree(start, middle, counter, 0) + tree(middle, end, counter + left, 0)
        return compress(IV, words, 0, 64, 4 | root)  # a parent
    return struct.pack("<8I", *tree(0, len(data), 0, 8))
