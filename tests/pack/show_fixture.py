"""Asks landfix info and landfix query about the fixture: pixel types, dates, bit planes.

    show_fixture.py LANDFIX SMALL_LFPACK
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

LANDFIX, PACK = sys.argv[1:3]


def run(*arguments):
    return subprocess.run([LANDFIX, *map(str, arguments)], capture_output=True, text=True)


def answer(*arguments):
    done = run(*arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def query(grid, *arguments, sigma_m=5):
    return json.loads(answer("query", PACK, "--grid", grid, "--json", "--sigma", sigma_m, *arguments))


def expect(found, expected):
    assert found == expected, f"expected {expected!r}, found {found!r}"


# The facts are those of tests/pack/fixture.cc: the north-western tile of gray shows the newest date, the south-western
# one both.
info = json.loads(answer("info", "--json", PACK))
expect({layer["name"]: (layer["pixel_type"], layer["channels"], layer["nodata"]) for layer in info["layers"]},
       {"gray": ("u8", 1, 0), "overview": ("u8", 3, 0), "orientation": ("bit", 4, 1), "height": ("i16", 1, -32768),
        "landmarks": ("landmarks", 0, 0), "roads": ("roads", 0, 0)})
expect(info["epochs"], [{"date": "2021-06-30", "sources": [0]}, {"date": "2009-08-18", "sources": [1]}])
assert "2009-08-18  1 image" in answer("info", PACK)

NEWEST, BOTH = ["2021-06-30"], ["2021-06-30", "2009-08-18"]
north, south, corner = "499840,4999552", "499840,4999296", "499840,4999424"
expect(query(north)["position"]["dates"], NEWEST)
expect(query(south)["position"]["dates"], BOTH)
expect(query(north)["region"]["dates"], {"newest": "2021-06-30", "oldest": "2021-06-30"})
expect(query(corner)["region"]["dates"], {"newest": "2021-06-30", "oldest": "2009-08-18"})
expect(query(north, "--layer", "orientation")["position"]["dates"], BOTH)
heights = query(north, "--layer", "height")
expect(heights["position"]["dates"], [])
expect(heights["region"]["dates"], {"newest": None, "oldest": None})
expect(heights["position"]["ground_height_from"], "height layer")  # compressed in this pack

# The share of pixels with data around the middle of the south-western tile, which has ponds without data, from the
# planes as the independent reader decodes them: all four are 1 there.
sys.path.insert(0, str(Path(PACK).parent))
sys.dont_write_bytecode = True
import read_pack

data = Path(PACK).read_bytes()
tiles = {(tile["layer"], tile["x"], tile["y"]): tile for tile in read_pack.read_pack(data)["tiles"]}
tile = tiles["orientation", 1952, 19528]
planes = read_pack.decode_planes(data[tile["offset"]:tile["offset"] + tile["length"]], 4)
region = query(south, "--layer", "orientation", sigma_m=20)["region"]
columns = range(int(region["west_m"]) - 499712, int(region["west_m"]) - 499712 + region["width_px"])
rows = range(4999424 - int(region["north_m"]), 4999424 - int(region["north_m"]) + region["height_px"])
without_data = [all(planes[8192 * p + 32 * r + c // 8] >> c % 8 & 1 for p in range(4)) for r in rows for c in columns]
expect(region["valid_share"], without_data.count(False) / len(without_data))
assert 0.5 < region["valid_share"] < 1, region

with tempfile.TemporaryDirectory() as folder:
    for layer in ("gray", "orientation"):
        answer("query", PACK, "--grid", corner, "--sigma", 5, "--layer", layer, "-o", Path(folder) / f"{layer}.tif")
    refused = run("query", PACK, "--grid", north, "--layer", "orientation", "-o", Path(folder) / "planes.png")
    expect(refused.returncode, 2)
    assert "4 channels" in refused.stderr and ".tif" in refused.stderr, refused.stderr
    expect(sorted(path.name for path in Path(folder).iterdir()), ["gray.tif", "orientation.tif"])
assert "14 tiles checked and decoded" in answer("verify", "--deep", PACK)
print("the tools show what was drawn")
