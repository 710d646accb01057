"""Compares what the independent reader says of the fixture with what the runtime says, field by field, and gives it
damaged copies.

    compare_readers.py LANDFIX_DRAW_FIXTURE FIXTURES
"""
import functools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

PUBLIC_KEY = "fcef46624f861db7df87fde57fe2a35a5eb9221b9cb5931ab2e53e7fdd5056f4"  # as in the fixtures' README


def differences(expected, found, path=""):
    if isinstance(expected, dict) and isinstance(found, dict):
        for name in sorted(expected.keys() | found.keys()):
            if name not in expected or name not in found:
                yield f"{path}.{name}: only {'expected' if name in expected else 'found'}"
            else:
                yield from differences(expected[name], found[name], f"{path}.{name}")
    elif isinstance(expected, list) and isinstance(found, list):
        if len(expected) != len(found):
            yield f"{path}: {len(expected)} items expected, {len(found)} found"
        for i, (e, f) in enumerate(zip(expected, found)):
            yield from differences(e, f, f"{path}[{i}]")
    elif path.endswith(".pixels") and found is None:
        pass  # a JPEG or Zstandard tile, which the independent reader does not decode
    elif expected != found or type(expected) is not type(found):
        yield f"{path}: expected {expected!r}, found {found!r}"


def leaves(value):
    if isinstance(value, (dict, list)):
        return sum(map(leaves, value.values() if isinstance(value, dict) else value))
    return 1


def compare(draw, reader, pack, decodable, fields):
    expected = json.loads(subprocess.run([draw, "describe", pack], check=True, capture_output=True).stdout)
    run = subprocess.run([sys.executable, reader, pack, "--key", PUBLIC_KEY], check=True, capture_output=True)
    found = json.loads(run.stdout)
    wrong = list(differences(expected, found))
    assert not wrong, "\n".join(wrong)
    decoded = sum(tile["pixels"] is not None for tile in found["tiles"])
    assert decoded == decodable, f"{decodable} tiles need no library to decode, {decoded} were decoded"
    assert leaves(found) > fields, "the fixture has lost its fields"
    print(f"{leaves(found)} fields are the same")


def cached_by_data(decode):
    known = {}

    def decoded(data, *others):
        if data not in known:
            known[data] = decode(data, *others)
        return known[data]

    return decoded


def refuse(reader, pack):
    """Every kind of damage ends with exit code 4 or a refusal, never with an answer."""
    sys.path.insert(0, str(reader.parent))
    sys.dont_write_bytecode = True
    import read_pack
    # Of the tiles that are not damaged, once.
    read_pack.decode_planes = functools.cache(read_pack.decode_planes)
    read_pack.decode_landmarks = cached_by_data(read_pack.decode_landmarks)
    read_pack.decode_roads = cached_by_data(read_pack.decode_roads)
    good = pack.read_bytes()
    read_pack.read_pack(good)
    blocks = read_pack.read_blocks(good, read_pack.read_header(good))
    end_of_directory = max(b["offset"] + 64 * b["count"] for b in blocks)
    places = {2000, *range(0, 300, 3), *range(4060, end_of_directory, 5), *range(end_of_directory, len(good), 997),
              len(good) - 1}
    for at in sorted(places):
        damaged = bytearray(good)
        damaged[at] ^= 0x04
        must_refuse(read_pack, bytes(damaged), f"byte {at} changed")
    for length in (0, 7, 100, 4096, 5000, end_of_directory, len(good) - 1):
        must_refuse(read_pack, good[:length], f"cut to {length} bytes")
    must_refuse(read_pack, good + b"\0", "a byte more")
    print(f"{len(places) + 8} damaged copies refused")
    with tempfile.TemporaryDirectory() as folder:
        cut = Path(folder) / "cut.lfpack"
        cut.write_bytes(good[:-1])
        assert subprocess.run([sys.executable, reader, cut], capture_output=True).returncode == 4
    other = PUBLIC_KEY[:-1] + "5"
    assert subprocess.run([sys.executable, reader, pack, "--key", other], capture_output=True).returncode == 5


def must_refuse(read_pack, data, what):
    try:
        read_pack.read_pack(data)
    except (read_pack.Refused, UnicodeDecodeError):
        return
    raise AssertionError(f"read_pack.py takes a pack with {what}")


if __name__ == "__main__":
    fixtures = Path(sys.argv[2])
    # Raw tiles of gray and orientation, and two tiles of bit planes coded in context; then one raw tile.
    compare(sys.argv[1], fixtures / "read_pack.py", fixtures / "small.lfpack", decodable=4, fields=1000)
    compare(sys.argv[1], fixtures / "read_pack.py", fixtures / "version_1_0.lfpack", decodable=1, fields=150)
    compare(sys.argv[1], fixtures / "read_pack.py", fixtures / "version_1_1.lfpack", decodable=4, fields=250)
    compare(sys.argv[1], fixtures / "read_pack.py", fixtures / "version_1_2.lfpack", decodable=4, fields=1000)
    refuse(fixtures / "read_pack.py", fixtures / "small.lfpack")
