#!/usr/bin/python3
"""Writes a VRT that repeats a raster to the east and south until it is large: repeat.py SOURCE WIDTH HEIGHT OUT.vrt

The period should not be a multiple of 256 pixels: a map pack stores equal tiles once, and would come out small.
"""
import os
import sys

from osgeo import gdal

gdal.UseExceptions()


def source_xml(path, band, x, y, width, height):
    return (f'<SimpleSource><SourceFilename relativeToVRT="0">{path}</SourceFilename><SourceBand>{band}</SourceBand>'
            f'<SrcRect xOff="0" yOff="0" xSize="{width}" ySize="{height}"/>'
            f'<DstRect xOff="{x}" yOff="{y}" xSize="{width}" ySize="{height}"/></SimpleSource>')


def repeat(source, width, height, output):
    path = os.path.abspath(source)
    data = gdal.Open(path)
    columns, rows = data.RasterXSize, data.RasterYSize
    transform = ", ".join(repr(v) for v in data.GetGeoTransform())
    bands = []
    for i in range(1, data.RasterCount + 1):
        band = data.GetRasterBand(i)
        pieces = "".join(source_xml(path, i, x, y, min(columns, width - x), min(rows, height - y))
                         for y in range(0, height, rows) for x in range(0, width, columns))
        colour = gdal.GetColorInterpretationName(band.GetColorInterpretation())
        bands.append(f'<VRTRasterBand dataType="{gdal.GetDataTypeName(band.DataType)}" band="{i}">'
                     f"<ColorInterp>{colour}</ColorInterp>{pieces}</VRTRasterBand>")
    with open(output, "w") as file:
        file.write(f'<VRTDataset rasterXSize="{width}" rasterYSize="{height}"><SRS>{data.GetProjection()}</SRS>'
                   f'<GeoTransform>{transform}</GeoTransform>{"".join(bands)}</VRTDataset>\n')


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    repeat(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
