// SPDX-License-Identifier: MIT
#include "ig/place/sun_place.h"

#include <cmath>

namespace karst::ig {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;

double sine(double angle_deg) {
  return std::sin(angle_deg * kRadiansPerDegree);
}
double cosine(double angle_deg) {
  return std::cos(angle_deg * kRadiansPerDegree);
}

}  // namespace

// The Julian day number as in the Explanatory Supplement to the Astronomical Almanac (Fliegel and Van
// Flandern), whose divisions are of whole numbers.
double days_of(int year, int month, int day, double seconds) {
  const int before = (month - 14) / 12;  // of January and February: -1
  const int number = 1461 * (year + 4800 + before) / 4 + 367 * (month - 2 - 12 * before) / 12 -
                     3 * ((year + 4900 + before) / 100) / 4 + day - 32'075;
  return number - 2'451'545 - 0.5 + seconds / 86'400;
}

SunPlace sun_place(double days, double latitude_deg, double longitude_deg) {
  const double mean_longitude = std::remainder(280.460 + 0.9856474 * days, 360.0);
  const double anomaly = std::remainder(357.528 + 0.9856003 * days, 360.0);
  const double ecliptic = mean_longitude + 1.915 * sine(anomaly) + 0.020 * sine(2 * anomaly);
  const double obliquity = 23.439 - 0.0000004 * days;
  const double x = cosine(ecliptic);
  const double y = cosine(obliquity) * sine(ecliptic);
  const double z = sine(obliquity) * sine(ecliptic);
  // Sidereal time of Greenwich, degrees.
  const double sidereal = std::remainder(280.46061837 + 360.98564736629 * days, 360.0);
  const double turn = sidereal + longitude_deg;  // from the equinox to the meridian of the place
  const double towards = x * cosine(turn) + y * sine(turn);
  const double east = y * cosine(turn) - x * sine(turn);
  const double up = towards * cosine(latitude_deg) + z * sine(latitude_deg);
  const double north = z * cosine(latitude_deg) - towards * sine(latitude_deg);
  SunPlace place;
  place.azimuth_deg = std::atan2(east, north) / kRadiansPerDegree;
  if (place.azimuth_deg < 0) place.azimuth_deg += 360;
  place.elevation_deg = std::atan2(up, std::hypot(east, north)) / kRadiansPerDegree;
  return place;
}

}  // namespace karst::ig
