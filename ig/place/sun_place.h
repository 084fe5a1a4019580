// SPDX-License-Identifier: MIT
// Where the sun stands.
#pragma once

namespace karst::ig {

// Days since noon UTC of 1 January 2000, of a date of the Gregorian calendar and a time of day, UTC.
double days_of(int year, int month, int day, double seconds);

// The Astronomical Almanac's low-precision formulas (section C, "Low precision formulas for the Sun's
// coordinates", 0.01 degrees in 1950..2050) and its mean sidereal time; without refraction and parallax.
struct SunPlace {
  double azimuth_deg = 0;    // clockwise from north
  double elevation_deg = 0;  // above the horizon
};
SunPlace sun_place(double days, double latitude_deg, double longitude_deg);

}  // namespace karst::ig
