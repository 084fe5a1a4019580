// SPDX-License-Identifier: MIT
// Rasters that GDAL itself writes, of every kind that is read: masks, mosaics, several files, and what is
// refused before GDAL follows it.
#include "bake/elevation/elevation.h"
#include "tests/bake/bake_files.h"
#include "tests/support/process.h"

#include <cpl_conv.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numeric>

namespace karst::bake {
namespace {

constexpr int kWidth = 6, kHeight = 5;

// A raster in memory, closed in the end.
class Source {
 public:
  Source(GDALDataType type, int width = kWidth, int height = kHeight, int bands = 1) {
    GDALRegister_MEM();
    file_ = GDALCreate(GDALGetDriverByName("MEM"), "", width, height, bands, type, nullptr);
    std::vector<double> values(static_cast<std::size_t>(width * height));
    for (int k = 1; k <= bands; ++k) {
      std::iota(values.begin(), values.end(), 100.0 + 1000 * (k - 1));
      EXPECT_EQ(GDALRasterIO(band(k), GF_Write, 0, 0, width, height, values.data(), width, height,
                             GDT_Float64, 0, 0),
                CE_None);
    }
  }
  ~Source() { GDALClose(file_); }
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  GDALRasterBandH band(int k = 1) const { return GDALGetRasterBand(file_, k); }
  Source& at(double west, double north, double step) {
    double place[6] = {west, step, 0, north, 0, -step};
    EXPECT_EQ(GDALSetGeoTransform(file_, place), CE_None);
    return *this;
  }
  Source& in(int epsg) {
    OGRSpatialReferenceH srs = OSRNewSpatialReference(nullptr);
    EXPECT_EQ(OSRImportFromEPSG(srs, epsg), OGRERR_NONE);
    OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
    EXPECT_EQ(GDALSetSpatialRef(file_, srs), CE_None);
    OSRRelease(srs);
    return *this;
  }
  void save(void (*add_driver)(), const char* driver, const std::string& path,
            std::initializer_list<const char*> options = {}) const {
    add_driver();
    std::vector<const char*> list(options);
    list.push_back(nullptr);
    GDALDatasetH copy = GDALCreateCopy(GDALGetDriverByName(driver), path.c_str(), file_, 0,
                                       const_cast<char**>(list.data()), nullptr, nullptr);
    ASSERT_NE(copy, nullptr) << driver;
    GDALClose(copy);
  }

 private:
  GDALDatasetH file_;
};

class Raster : public ::testing::Test {
 protected:
  void expect_error(const ReadElevation& read, const std::string& words) {
    const std::string message = error_of(read);
    EXPECT_NE(message.find(words), std::string::npos) << "got: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }

  test::Folder folder_;
};

TEST_F(Raster, EveryKindIsRead) {
  const struct {
    void (*add_driver)();
    const char* driver;
    const char* name;
  } kinds[] = {
      {GDALRegister_GTiff, "GTiff", "a.tif"},     {GDALRegister_HFA, "HFA", "a.img"},
      {GDALRegister_EHdr, "EHdr", "a.bil"},       {GDALRegister_ENVI, "ENVI", "a.raw"},
      {GDALRegister_AAIGrid, "AAIGrid", "a.asc"}, {GDALRegister_JP2OpenJPEG, "JP2OpenJPEG", "a.jp2"}};
  Source placed(GDT_Int16);
  placed.at(500'000, 4'000'000, 30).in(32611);
  for (const auto& kind : kinds) {
    SCOPED_TRACE(kind.driver);
    const std::string path = folder_.path(kind.name);
    const bool lossy = std::string(kind.driver) == "JP2OpenJPEG";
    placed.save(kind.add_driver, kind.driver, path,
                lossy ? std::initializer_list<const char*>{"REVERSIBLE=YES", "QUALITY=100"}
                      : std::initializer_list<const char*>{});
    const Elevation e = elevation_of({.path = path});
    ASSERT_EQ(e.width, kWidth);
    ASSERT_EQ(e.height, kHeight);
    EXPECT_DOUBLE_EQ(e.spacing_x_m, 30);
    EXPECT_DOUBLE_EQ(e.spacing_z_m, 30);
    for (std::size_t k = 0; k < e.samples(); ++k) EXPECT_EQ(e.heights_m[k], 100 + static_cast<float>(k));
    EXPECT_EQ(e.source.rfind(kind.driver, 0), 0u) << e.source;
  }
}

// What says where it lies by its name and its kind.
TEST_F(Raster, TilesOfSrtmDtedAndUsgsAreRead) {
  Source srtm(GDT_Int16, 1201, 1201);
  srtm.at(7 - 0.5 / 1200, 47 + 0.5 / 1200, 1.0 / 1200).in(4326);
  const auto set_first = [&](std::int16_t height) {
    ASSERT_EQ(GDALRasterIO(srtm.band(), GF_Write, 0, 0, 1, 1, &height, 1, 1, GDT_Int16, 0, 0), CE_None);
  };
  set_first(-32768);
  srtm.save(GDALRegister_SRTMHGT, "SRTMHGT", folder_.path("N46E007.hgt"));
  set_first(-32767);
  srtm.save(GDALRegister_DTED, "DTED", folder_.path("n46.dt1"));
  srtm.save(GDALRegister_USGSDEM, "USGSDEM", folder_.path("n46.dem"));
  for (const char* name : {"N46E007.hgt", "n46.dt1", "n46.dem"}) {
    SCOPED_TRACE(name);
    const Elevation e = elevation_of({.path = folder_.path(name), .crop = {0, 0, 100, 100}});
    EXPECT_EQ(e.voids, 1u);
    EXPECT_EQ(e.heights_m[1], 101);
    // At 46.96 degrees a degree is 76.1 km by 111.17 km.
    EXPECT_NEAR(e.spacing_x_m, 76'120 / 1200.0, 0.1);
    EXPECT_NEAR(e.spacing_z_m, 111'170 / 1200.0, 0.1);
  }
}

// Masks inside a file, beside it, and in a band.
TEST_F(Raster, MasksMarkVoids) {
  const std::vector<unsigned char> mask = [] {
    std::vector<unsigned char> m(kWidth * kHeight, 255);
    m[4] = m[17] = 0;
    return m;
  }();
  GDALRegister_GTiff();
  for (const char* inside : {"YES", "NO"}) {
    SCOPED_TRACE(inside);
    const std::string path = folder_.path(std::string("mask_") + inside + ".tif");
    CPLSetConfigOption("GDAL_TIFF_INTERNAL_MASK", inside);
    GDALDatasetH file =
        GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), kWidth, kHeight, 1, GDT_Int16, nullptr);
    ASSERT_EQ(GDALCreateDatasetMaskBand(file, GMF_PER_DATASET), CE_None);
    ASSERT_EQ(GDALRasterIO(GDALGetMaskBand(GDALGetRasterBand(file, 1)), GF_Write, 0, 0, kWidth, kHeight,
                           const_cast<unsigned char*>(mask.data()), kWidth, kHeight, GDT_Byte, 0, 0),
              CE_None);
    GDALClose(file);
    const Elevation e = elevation_of({.path = path, .pixel_size_m = 30});
    EXPECT_EQ(e.voids, 2u);
    EXPECT_EQ(e.valid[4] + e.valid[17], 0);
  }
  Source alpha(GDT_Int16, kWidth, kHeight, 2);
  GDALSetRasterColorInterpretation(alpha.band(2), GCI_AlphaBand);
  std::vector<double> opaque(mask.begin(), mask.end());
  ASSERT_EQ(GDALRasterIO(alpha.band(2), GF_Write, 0, 0, kWidth, kHeight, opaque.data(), kWidth, kHeight,
                         GDT_Float64, 0, 0),
            CE_None);
  alpha.save(GDALRegister_GTiff, "GTiff", folder_.path("alpha.tif"), {"ALPHA=YES"});
  const Elevation e = elevation_of({.path = folder_.path("alpha.tif"), .pixel_size_m = 30});
  EXPECT_EQ(e.voids, 2u);
  EXPECT_EQ(e.heights_m[5], 105);
}

// Whole numbers beyond 16 bits, and nodata of them.
TEST_F(Raster, LongNumbersKeepTheirNodata) {
  for (const GDALDataType type : {GDT_Int32, GDT_UInt32, GDT_Int64, GDT_UInt64, GDT_Float64}) {
    SCOPED_TRACE(GDALGetDataTypeName(type));
    Source source(type);
    if (type == GDT_Int64) {
      GDALSetRasterNoDataValueAsInt64(source.band(), 103);
    } else if (type == GDT_UInt64) {
      GDALSetRasterNoDataValueAsUInt64(source.band(), 103);
    } else {
      GDALSetRasterNoDataValue(source.band(), 103);
    }
    source.save(GDALRegister_GTiff, "GTiff", folder_.path("a.tif"));
    const Elevation e = elevation_of({.path = folder_.path("a.tif"), .pixel_size_m = 30});
    EXPECT_EQ(e.voids, 1u);
    EXPECT_EQ(e.valid[3], 0);
    EXPECT_EQ(e.heights_m[4], 104);
  }
}

// Two halves side by side, with a column that both have, in either order; and one that lies apart.
TEST_F(Raster, SeveralFilesMakeOneGrid) {
  const auto save = [&](const char* name, double west, double north, double step, int epsg) {
    Source source(GDT_Float32);
    source.at(west, north, step).in(epsg);
    source.save(GDALRegister_GTiff, "GTiff", folder_.path(name));
    return folder_.path(name);
  };
  const std::string a = save("a.tif", 500'000, 4'000'000, 30, 32611);
  const std::string b = save("b.tif", 500'000 + 30 * 5, 4'000'000 - 30 * 2, 30, 32611);
  const Elevation both = elevation_of({.path = a, .more = {b}});
  ASSERT_EQ(both.width, 11);
  ASSERT_EQ(both.height, 7);
  EXPECT_EQ(both.voids, 77u - 30 - 30 + 3);
  EXPECT_EQ(both.heights_m[both.at(0, 0)], 100);
  EXPECT_EQ(both.heights_m[both.at(10, 6)], 129);
  EXPECT_EQ(both.heights_m[both.at(5, 2)], 117) << "the first that knows a sample says it";
  EXPECT_EQ(both.valid[both.at(10, 0)], 0);
  EXPECT_NE(both.source.find("2 files"), std::string::npos);
  const Elevation turned = elevation_of({.path = b, .more = {a}});
  EXPECT_EQ(turned.heights_m[turned.at(5, 2)], 100);
  EXPECT_EQ(turned.valid, both.valid);
  const Elevation crop = elevation_of({.path = a, .more = {b}, .crop = {4, 1, 4, 4}});
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(crop.heights_m[crop.at(i, j)], both.heights_m[both.at(4 + i, 1 + j)]) << i << ' ' << j;
    }
  }
  expect_error({.path = a, .more = {save("c.tif", 500'010, 4'000'000, 30, 32611)}}, "between those of");
  expect_error({.path = a, .more = {save("c.tif", 500'180, 4'000'000, 31, 32611)}}, "sample size");
  expect_error({.path = a, .more = {save("c.tif", 500'180, 4'000'000, 30, 32612)}}, "reference system");
  expect_error({.path = a, .more = {save("c.tif", 900'000'020, 4'000'000, 30, 32611)}}, "a side");
  Source(GDT_Float32).save(GDALRegister_GTiff, "GTiff", folder_.path("d.tif"));
  expect_error({.path = a, .more = {folder_.path("d.tif")}}, "does not say where it lies");
}

class Mosaic : public Raster {
 protected:
  Mosaic() {
    Source source(GDT_Int16);
    source.at(500'000, 4'000'000, 30).in(32611);
    source.save(GDALRegister_GTiff, "GTiff", folder_.path("tile.tif"));
  }
  // Of ten columns, of which the tile has six.
  std::string vrt(const std::string& more, const std::string& file, const std::string& attribute = "",
                  const std::string& sides = R"(rasterXSize="10" rasterYSize="5")") {
    return folder_.write("a.vrt", "<VRTDataset " + sides + ">" + R"(
  <GeoTransform>500000, 30, 0, 4000000, 0, -30</GeoTransform>
  <VRTRasterBand dataType="Int16" band="1" )" +
                                      attribute + ">" + more + R"(
    <SimpleSource><SourceFilename relativeToVRT="1">)" +
                                      file +
                                      R"(</SourceFilename><SourceBand>1</SourceBand>
      <SrcRect xOff="0" yOff="0" xSize="6" ySize="5"/><DstRect xOff="0" yOff="0" xSize="6" ySize="5"/>
    </SimpleSource></VRTRasterBand></VRTDataset>)");
  }
};

TEST_F(Mosaic, PartsOfItsFolderAreRead) {
  const Elevation e = elevation_of({.path = vrt("<NoDataValue>-5</NoDataValue>", "tile.tif")});
  ASSERT_EQ(e.width, 10);
  EXPECT_EQ(e.heights_m[11], 107);
  EXPECT_EQ(e.voids, 20u);
  const std::vector<std::string> files = ReadElevation{.path = folder_.path("a.vrt")}.files();
  EXPECT_TRUE(std::any_of(files.begin(), files.end(), [&](const std::string& file) {
    std::error_code failed;
    return std::filesystem::equivalent(file, folder_.path("tile.tif"), failed);
  })) << "an output that is a part is seen";
}

// Where no part is, and where a part is void, GDAL reads 0.
TEST_F(Mosaic, GapsNeedAValue) {
  expect_error({.path = vrt("", "tile.tif")}, "-vrtnodata");
  EXPECT_EQ(elevation_of({.path = vrt("", "tile.tif"), .crop = {1, 0, 5, 5}}).voids, 0u);
  std::string text = test::read_text(vrt("", "tile.tif", "", R"(rasterXSize="6" rasterYSize="5")"));
  EXPECT_EQ(elevation_of({.path = folder_.path("a.vrt")}).voids, 0u);
  for (std::size_t at = 0; (at = text.find("SimpleSource", at)) != std::string::npos; ++at)
    text.replace(at, 12, "ComplexSource");
  text.insert(text.find("</ComplexSource>"), "<NODATA>107</NODATA>");
  expect_error({.path = folder_.write("a.vrt", text)}, "-vrtnodata");
  std::string many = test::read_text(vrt("", "tile.tif", "", R"(rasterXSize="6" rasterYSize="5")"));
  const std::size_t first = many.find("<SimpleSource>");
  const std::string part = many.substr(first, many.find("</VRTRasterBand>") - first);
  for (int k = 0; k < 200; ++k) many.insert(first, part);
  expect_error({.path = folder_.write("a.vrt", many)}, "-vrtnodata");
  text.insert(text.find("<ComplexSource>"), "<NoDataValue>-5</NoDataValue>");
  EXPECT_EQ(elevation_of({.path = folder_.write("a.vrt", text)}).voids, 1u);
}

TEST_F(Mosaic, NothingElseIsFollowed) {
  test::Folder other;
  std::filesystem::copy(folder_.path("tile.tif"), other.path("tile.tif"));
  expect_error({.path = vrt("", other.path("tile.tif"))}, "not in its folder");
  std::filesystem::create_symlink(other.path("tile.tif"), folder_.path("link.tif"));
  expect_error({.path = vrt("", "link.tif")}, "not in its folder");
  expect_error({.path = vrt("", "/vsicurl/http://127.0.0.1:9/tile.tif")}, "is no file");
  expect_error({.path = vrt("", "missing.tif")}, "is no file");
  expect_error({.path = vrt("", "tile.tif", R"(subClass="VRTDerivedRasterBand")")}, "computed");
  expect_error({.path = vrt("<PixelFunctionType>sum</PixelFunctionType>", "tile.tif")}, "PixelFunctionType");
  folder_.write("b.vrt", test::read_text(vrt("", "tile.tif")));
  expect_error({.path = vrt("", "b.vrt")}, "another VRT");
  expect_error({.path = folder_.write("x.vrt", std::string("<VRTDataset"))}, "x.vrt");
}

// Each part is read wherever it lies, under others too.
TEST_F(Mosaic, PartsThatLieOverEachOtherAreRefused) {
  const std::string part = R"(<SimpleSource><SourceFilename relativeToVRT="1">tile.tif</SourceFilename>
    <SourceBand>1</SourceBand><SrcRect xOff="0" yOff="0" xSize="6" ySize="5"/>)";
  const auto over = [&](int count, const std::string& place) {
    std::string parts;
    for (int k = 0; k < count; ++k) parts += part + place + "</SimpleSource>";
    return vrt("<NoDataValue>-5</NoDataValue>" + parts, "tile.tif", "",
               R"(rasterXSize="1000" rasterYSize="500")");
  };
  const std::string whole = R"(<DstRect xOff="0" yOff="0" xSize="1000" ySize="500"/>)";
  const std::string small = R"(<DstRect xOff="0" yOff="0" xSize="6" ySize="5"/>)";
  EXPECT_EQ(elevation_of({.path = over(16, whole)}).voids, 0u);
  expect_error({.path = over(17, whole)}, "lie over each other");
  expect_error({.path = over(17, "")}, "lie over each other");
  EXPECT_GT(elevation_of({.path = over(17, small)}).voids, 0u);
}

// A part's file is decoded in whole blocks, however little is shown of it.
TEST_F(Mosaic, PartsThatTakeMoreToDecodeThanTheyShowAreRefused) {
  Source sea(GDT_Byte, 2'000, 2'000);
  GDALFillRaster(sea.band(), 7, 0);
  const auto parts = [&](int count, const std::string& from) {
    std::string text;
    for (int k = 0; k < count; ++k) {
      const std::string name = "sea" + std::to_string(k) + ".tif";
      sea.save(GDALRegister_GTiff, "GTiff", folder_.path(name), {"COMPRESS=DEFLATE", "BLOCKYSIZE=2000"});
      text += "<SimpleSource><SourceFilename relativeToVRT=\"1\">" + name +
              "</SourceFilename><SourceBand>1</SourceBand>" + from +
              R"(<DstRect xOff="0" yOff="0" xSize="6" ySize="5"/></SimpleSource>)";
    }
    return vrt("<NoDataValue>-5</NoDataValue>" + text, "tile.tif");
  };
  const std::string little = R"(<SrcRect xOff="0" yOff="0" xSize="6" ySize="5"/>)";
  EXPECT_EQ(elevation_of({.path = parts(1, little)}).voids, 20u);
  for (const std::string& from :
       {little, std::string(), std::string(R"(<SrcRect xSize="1e9" ySize="1e9"/>)")})
    expect_error({.path = parts(3, from)}, "decoded to much more");
}

TEST_F(Mosaic, ABillionSamplesOfNothingAreRefused) {
  const std::string path = vrt("", "tile.tif", "", R"(rasterXSize="32768" rasterYSize="32768")");
  expect_error({.path = path}, "size");
  const std::string wide = vrt("", "tile.tif", "", R"(rasterXSize="32768" rasterYSize="8192")");
  expect_error({.path = wide}, "--crop");
  EXPECT_EQ(elevation_of({.path = wide, .crop = {0, 0, 6, 5}}).voids, 0u);
}

// Compressed to a thousandth: one strip of the whole, and tiles of a sea.
TEST_F(Raster, BombsAreRefusedAndSeasAreNot) {
  Source sea(GDT_Byte, 9'000, 9'000);
  const double flat = 7;
  GDALFillRaster(sea.band(), flat, 0);
  sea.save(GDALRegister_GTiff, "GTiff", folder_.path("strip.tif"), {"COMPRESS=DEFLATE", "BLOCKYSIZE=9000"});
  const ReadElevation strip{.path = folder_.path("strip.tif"), .pixel_size_m = 1, .allow_8bit = true};
  expect_error(strip, "--max-samples 81000000");
  sea.save(GDALRegister_GTiff, "GTiff", folder_.path("tiles.tif"), {"COMPRESS=DEFLATE", "TILED=YES"});
  ReadElevation tiles{.path = folder_.path("tiles.tif"), .pixel_size_m = 1, .allow_8bit = true};
  expect_error(tiles, "--max-samples 81000000");
  tiles.max_samples = 81'000'000;
  EXPECT_EQ(elevation_of(tiles).heights_m[80'999'999], 7);
  tiles.max_samples = 0;
  const int crop[] = {100, 100, 800, 800};
  std::copy(std::begin(crop), std::end(crop), tiles.crop);
  EXPECT_EQ(elevation_of(tiles).heights_m[639'999], 7);
}

TEST_F(Raster, OfSeveralInAFileTheFirstIsToldToBeTaken) {
  const std::string path = folder_.path("pages.tif");
  Source(GDT_Int16).save(GDALRegister_GTiff, "GTiff", path);
  EXPECT_TRUE(elevation_of({.path = path, .pixel_size_m = 30}).warnings.empty());
  Source(GDT_Int16, 9, 9).save(GDALRegister_GTiff, "GTiff", path, {"APPEND_SUBDATASET=YES"});
  const Elevation e = elevation_of({.path = path, .pixel_size_m = 30});
  EXPECT_EQ(e.width, kWidth);
  ASSERT_EQ(e.warnings.size(), 1u);
  EXPECT_NE(e.warnings[0].find("several rasters"), std::string::npos);
}

// Tiles that a GeoTIFF leaves out are 0 to GDAL, unless it names a nodata value.
TEST_F(Raster, TilesThatAreLeftOutAreVoid) {
  GDALRegister_GTiff();
  const std::string path = folder_.path("sparse.tif");
  std::vector<const char*> options = {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16", "SPARSE_OK=YES",
                                      nullptr};
  GDALDatasetH file = GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), 40, 40, 1, GDT_Int16,
                                 const_cast<char**>(options.data()));
  std::vector<std::int16_t> tile(16 * 16, 300);
  ASSERT_EQ(GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 16, 16, 16, 16, tile.data(), 16, 16, GDT_Int16,
                         0, 0),
            CE_None);
  GDALClose(file);
  const Elevation e = elevation_of({.path = path, .pixel_size_m = 30});
  EXPECT_EQ(e.voids, 40u * 40 - 256);
  EXPECT_EQ(e.heights_m[e.at(20, 20)], 300);
}

}  // namespace
}  // namespace karst::bake
