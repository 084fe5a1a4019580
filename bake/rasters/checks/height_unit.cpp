// SPDX-License-Identifier: MIT
#include "bake/rasters/checks/height_unit.h"

#include <ogr_srs_api.h>

#include <cstdlib>
#include <sstream>
#include <string_view>

namespace karst::bake {
namespace {

// Of a unit of heights, by the names that drivers give it; 0: not known.
double metres_of(std::string_view name) {
  const std::string unit = lower_case(name);
  static constexpr struct {
    std::string_view name;
    double metres;
  } kUnits[] = {{"m", 1},
                {"metre", 1},
                {"metres", 1},
                {"meter", 1},
                {"meters", 1},
                {"ft", 0.3048},
                {"foot", 0.3048},
                {"feet", 0.3048},
                {"us survey foot", 1200.0 / 3937},
                {"us survey feet", 1200.0 / 3937},
                {"foot_us", 1200.0 / 3937},
                {"feet_us", 1200.0 / 3937},
                {"us-ft", 1200.0 / 3937},
                {"international foot", 0.3048},
                {"international feet", 0.3048},
                {"decimeters", 0.1},
                {"decimetres", 0.1},
                {"ftus", 1200.0 / 3937},
                {"cm", 0.01},
                {"centimetre", 0.01},
                {"centimeter", 0.01},
                {"dm", 0.1},
                {"decimetre", 0.1},
                {"decimeter", 0.1},
                {"mm", 0.001},
                {"millimetre", 0.001},
                {"millimeter", 0.001},
                {"km", 1000},
                {"kilometre", 1000},
                {"kilometer", 1000}};
  for (const auto& known : kUnits) {
    if (known.name == unit) return known.metres;
  }
  return 0;
}

// Of the Zunits of a .prj that ArcInfo wrote, which GDAL leaves out.
void read_zunits(const CheckedRaster& raster, HeightUnit& unit) {
  std::istringstream lines(lower_case(text_beside(raster.file, ".prj")));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key;
    if (!(words >> key >> unit.name) || key != "zunits" || unit.name == "no") continue;
    unit.is_said = true;
    unit.metres = metres_of(unit.name);
    char* end = nullptr;
    const double a_metre = std::strtod(unit.name.c_str(), &end);
    if (*end == '\0' && a_metre > 0) unit.metres = 1 / a_metre;
    return;
  }
  unit.name.clear();
}

}  // namespace

HeightUnit height_unit(const CheckedRaster& raster, OGRSpatialReferenceH srs) {
  HeightUnit unit;
  unit.name = GDALGetRasterUnitType(raster.band);
  const std::size_t first = unit.name.find_first_not_of(' '), last = unit.name.find_last_not_of(' ');
  unit.name = first == std::string::npos ? std::string() : unit.name.substr(first, last - first + 1);
  unit.metres = metres_of(unit.name);
  unit.is_said = !unit.name.empty();
  const bool is_vertical = srs != nullptr && OSRGetAttrValue(srs, "VERT_CS", 0) != nullptr;
  if (is_vertical) {
    OGRAxisOrientation axis = OAO_Other;
    OSRGetAxis(srs, "VERT_CS", 0, &axis);
    unit.is_depth = axis == OAO_Down;
  }
  if (unit.is_said) return unit;
  if (is_vertical) {
    char* name = nullptr;
    unit.metres = OSRGetTargetLinearUnits(srs, "VERT_CS", &name);
    unit.name = name == nullptr ? "" : name;
    unit.is_said = true;
    return unit;
  }
  read_zunits(raster, unit);
  return unit;
}

}  // namespace karst::bake
