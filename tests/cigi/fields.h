// SPDX-License-Identifier: MIT
// Every field of every packet by its name: tests fill, compare and print packets by it.
#pragma once

#include "ig/cigi/packets.h"

#include <limits>

namespace karst::cigi {

enum class In : std::uint8_t { both, v3, v4 };

struct About {
  unsigned most = std::numeric_limits<unsigned>::max();  // of numbers with fewer values than their type
  bool valid = true;                                     // another field says that it counts
  In in = In::both;
};

// fields(packet, f) calls f(name, member, About) for each field, those before that say whether it is valid.
template <class F>
void fields(IgControl& p, F f) {
  f("database", p.database, About{});
  f("mode", p.mode, About{2});
  f("timestamp_valid", p.timestamp_valid, About{});
  f("smoothing", p.smoothing, About{});
  f("entity_type_substitution", p.entity_type_substitution, About{1, true, In::v4});
  f("host_frame", p.host_frame, About{});
  f("timestamp_10us", p.timestamp_10us, About{});
  f("last_ig_frame", p.last_ig_frame, About{});
}
template <class F>
void fields(EntityControl& p, F f) {
  f("entity", p.entity, About{});
  f("state", p.state, About{2});
  f("collision_detection", p.collision_detection, About{});
  f("inherit_alpha", p.inherit_alpha, About{});
  f("smoothing", p.smoothing, About{});
  f("alpha", p.alpha, About{});
  f("type", p.type, About{});
  f("extended_type", p.extended_type, About{1, true, In::v4});
  f("kind", p.kind, About{255, true, In::v4});
  f("domain", p.domain, About{255, true, In::v4});
  f("category", p.category, About{255, true, In::v4});
  f("subcategory", p.subcategory, About{255, true, In::v4});
  f("specific", p.specific, About{255, true, In::v4});
  f("extra", p.extra, About{255, true, In::v4});
  f("animation_backward", p.animation_backward, About{1, true, In::v3});
  f("animation_loop", p.animation_loop, About{1, true, In::v3});
  f("animation", p.animation, About{3, true, In::v3});
}
template <class F>
void fields(EntityPosition& p, F f) {
  f("entity", p.entity, About{});
  f("attached", p.attached, About{});
  f("clamp", p.clamp, About{2});
  f("parent", p.parent, About{});
  f("roll_deg", p.roll_deg, About{});
  f("pitch_deg", p.pitch_deg, About{});
  f("yaw_deg", p.yaw_deg, About{});
  f("latitude_deg_or_x_m", p.latitude_deg_or_x_m, About{});
  f("longitude_deg_or_y_m", p.longitude_deg_or_y_m, About{});
  f("altitude_m_or_z_m", p.altitude_m_or_z_m, About{});
}
template <class F>
void fields(RateControl& p, F f) {
  f("entity", p.entity, About{});
  f("part", p.part, About{});
  f("of_part", p.of_part, About{});
  f("local", p.local, About{});
  f("x_m_s", p.x_m_s, About{});
  f("y_m_s", p.y_m_s, About{});
  f("z_m_s", p.z_m_s, About{});
  f("roll_deg_s", p.roll_deg_s, About{});
  f("pitch_deg_s", p.pitch_deg_s, About{});
  f("yaw_deg_s", p.yaw_deg_s, About{});
}
template <class F>
void fields(ComponentControl& p, F f) {
  f("short_form", p.short_form, About{});
  f("component", p.component, About{});
  f("instance", p.instance, About{});
  f("component_class", p.component_class, About{63});
  f("state", p.state, About{});
  f("word1", p.words[0], About{});
  f("word2", p.words[1], About{});
  f("word3", p.words[2], About{~0u, !p.short_form});
  f("word4", p.words[3], About{~0u, !p.short_form});
  f("word5", p.words[4], About{~0u, !p.short_form});
  f("word6", p.words[5], About{~0u, !p.short_form});
}
template <class F>
void fields(CelestialSphereControl& p, F f) {
  f("ephemeris", p.ephemeris, About{});
  f("sun", p.sun, About{});
  f("moon", p.moon, About{});
  f("stars", p.stars, About{});
  f("date_time_valid", p.date_time_valid, About{});
  f("hour", p.hour, About{23, p.date_time_valid});
  f("minute", p.minute, About{59, p.date_time_valid});
  f("second", p.second, About{~0u, p.date_time_valid, In::v4});
  f("date_mmddyyyy", p.date_mmddyyyy, About{12'319'999, p.date_time_valid});
  f("star_intensity_percent", p.star_intensity_percent, About{});
}
template <class F>
void fields(AtmosphereControl& p, F f) {
  f("model", p.model, About{});
  f("humidity_percent", p.humidity_percent, About{100});
  f("air_temperature_c", p.air_temperature_c, About{});
  f("visibility_m", p.visibility_m, About{});
  f("horizontal_wind_m_s", p.horizontal_wind_m_s, About{});
  f("vertical_wind_m_s", p.vertical_wind_m_s, About{});
  f("wind_direction_deg", p.wind_direction_deg, About{});
  f("pressure_hpa", p.pressure_hpa, About{});
}
template <class F>
void fields(WeatherControl& p, F f) {
  f("entity_or_region", p.entity_or_region, About{});
  f("layer", p.layer, About{});
  f("enabled", p.enabled, About{});
  f("scud", p.scud, About{});
  f("random_winds", p.random_winds, About{});
  f("random_lightning", p.random_lightning, About{});
  f("top_scud", p.top_scud, About{1, true, In::v4});
  f("cloud_type", p.cloud_type, About{15});
  f("scope", p.scope, About{2});
  f("severity", p.severity, About{5});
  f("humidity_percent", p.humidity_percent, About{100});
  f("air_temperature_c", p.air_temperature_c, About{});
  f("visibility_m", p.visibility_m, About{});
  f("scud_percent", p.scud_percent, About{});
  f("coverage_percent", p.coverage_percent, About{});
  f("base_elevation_m", p.base_elevation_m, About{});
  f("thickness_m", p.thickness_m, About{});
  f("transition_m", p.transition_m, About{});
  f("horizontal_wind_m_s", p.horizontal_wind_m_s, About{});
  f("vertical_wind_m_s", p.vertical_wind_m_s, About{});
  f("wind_direction_deg", p.wind_direction_deg, About{});
  f("pressure_hpa", p.pressure_hpa, About{});
  f("aerosol_g_m3", p.aerosol_g_m3, About{});
  f("top_scud_percent", p.top_scud_percent, About{~0u, true, In::v4});
  f("top_transition_m", p.top_transition_m, About{~0u, true, In::v4});
}
template <class F>
void fields(ViewControl& p, F f) {
  f("view", p.view, About{});
  f("group", p.group, About{});
  f("entity", p.entity, About{});
  f("x_valid", p.x_valid, About{});
  f("y_valid", p.y_valid, About{});
  f("z_valid", p.z_valid, About{});
  f("roll_valid", p.roll_valid, About{});
  f("pitch_valid", p.pitch_valid, About{});
  f("yaw_valid", p.yaw_valid, About{});
  f("x_m", p.x_m, About{~0u, p.x_valid});
  f("y_m", p.y_m, About{~0u, p.y_valid});
  f("z_m", p.z_m, About{~0u, p.z_valid});
  f("roll_deg", p.roll_deg, About{~0u, p.roll_valid});
  f("pitch_deg", p.pitch_deg, About{~0u, p.pitch_valid});
  f("yaw_deg", p.yaw_deg, About{~0u, p.yaw_valid});
}
template <class F>
void fields(ViewDefinition& p, F f) {
  f("view", p.view, About{});
  f("group", p.group, About{});
  f("near_valid", p.near_valid, About{});
  f("far_valid", p.far_valid, About{});
  f("left_valid", p.left_valid, About{});
  f("right_valid", p.right_valid, About{});
  f("top_valid", p.top_valid, About{});
  f("bottom_valid", p.bottom_valid, About{});
  f("mirror", p.mirror, About{3});
  f("pixel_replication", p.pixel_replication, About{7});
  f("parallel", p.parallel, About{});
  f("reorder", p.reorder, About{});
  f("type", p.type, About{7});
  f("near_m", p.near_m, About{~0u, p.near_valid});
  f("far_m", p.far_m, About{~0u, p.far_valid});
  f("left_deg", p.left_deg, About{~0u, p.left_valid});
  f("right_deg", p.right_deg, About{~0u, p.right_valid});
  f("top_deg", p.top_deg, About{~0u, p.top_valid});
  f("bottom_deg", p.bottom_deg, About{~0u, p.bottom_valid});
}
template <class F>
void fields(HatHotRequest& p, F f) {
  f("id", p.id, About{});
  f("type", p.type, About{2});
  f("system", p.system, About{1});
  f("update_period", p.update_period, About{});
  f("entity", p.entity, About{});
  f("latitude_deg_or_x_m", p.latitude_deg_or_x_m, About{});
  f("longitude_deg_or_y_m", p.longitude_deg_or_y_m, About{});
  f("altitude_m_or_z_m", p.altitude_m_or_z_m, About{});
}
template <class F>
void fields(LosSegmentRequest& p, F f) {
  f("id", p.id, About{});
  f("extended", p.extended, About{});
  f("source", p.source, About{1});
  f("destination", p.destination, About{1});
  f("response", p.response, About{1});
  f("destination_entity_valid", p.destination_entity_valid, About{});
  f("alpha_threshold", p.alpha_threshold, About{});
  f("update_period", p.update_period, About{});
  f("entity", p.entity, About{});
  f("destination_entity", p.destination_entity, About{});
  f("source_latitude_deg_or_x_m", p.source_latitude_deg_or_x_m, About{});
  f("source_longitude_deg_or_y_m", p.source_longitude_deg_or_y_m, About{});
  f("source_altitude_m_or_z_m", p.source_altitude_m_or_z_m, About{});
  f("destination_latitude_deg_or_x_m", p.destination_latitude_deg_or_x_m, About{});
  f("destination_longitude_deg_or_y_m", p.destination_longitude_deg_or_y_m, About{});
  f("destination_altitude_m_or_z_m", p.destination_altitude_m_or_z_m, About{});
  f("material_mask", p.material_mask, About{});
}
template <class F>
void fields(LosVectorRequest& p, F f) {
  f("id", p.id, About{});
  f("extended", p.extended, About{});
  f("source", p.source, About{1});
  f("response", p.response, About{1});
  f("alpha_threshold", p.alpha_threshold, About{});
  f("update_period", p.update_period, About{});
  f("entity", p.entity, About{});
  f("azimuth_deg", p.azimuth_deg, About{});
  f("elevation_deg", p.elevation_deg, About{});
  f("minimum_range_m", p.minimum_range_m, About{});
  f("maximum_range_m", p.maximum_range_m, About{});
  f("source_latitude_deg_or_x_m", p.source_latitude_deg_or_x_m, About{});
  f("source_longitude_deg_or_y_m", p.source_longitude_deg_or_y_m, About{});
  f("source_altitude_m_or_z_m", p.source_altitude_m_or_z_m, About{});
  f("material_mask", p.material_mask, About{});
}
template <class F>
void fields(StartOfFrame& p, F f) {
  f("database", p.database, About{});
  f("status", p.status, About{255, true, In::v3});
  f("mode", p.mode, About{3});
  f("timestamp_valid", p.timestamp_valid, About{});
  f("own_earth_model", p.own_earth_model, About{});
  f("overframing", p.overframing, About{1, true, In::v4});
  f("paging", p.paging, About{1, true, In::v4});
  f("too_much_variable_data", p.too_much_variable_data, About{1, true, In::v4});
  f("ig_frame", p.ig_frame, About{});
  f("timestamp_10us", p.timestamp_10us, About{});
  f("last_host_frame", p.last_host_frame, About{});
}
template <class F>
void fields(HatHotResponse& p, F f) {
  f("id", p.id, About{});
  f("valid", p.valid, About{});
  f("type", p.type, About{1});
  f("host_frame_low", p.host_frame_low, About{15});
  f("height_m", p.height_m, About{~0u, p.valid});
}
template <class F>
void fields(HatHotExtendedResponse& p, F f) {
  f("id", p.id, About{});
  f("valid", p.valid, About{});
  f("host_frame_low", p.host_frame_low, About{15});
  f("hat_m", p.hat_m, About{~0u, p.valid});
  f("hot_m", p.hot_m, About{~0u, p.valid});
  f("material", p.material, About{~0u, p.valid});
  f("normal_azimuth_deg", p.normal_azimuth_deg, About{~0u, p.valid});
  f("normal_elevation_deg", p.normal_elevation_deg, About{~0u, p.valid});
}
template <class F>
void fields(LosResponse& p, F f) {
  f("id", p.id, About{});
  f("valid", p.valid, About{});
  f("entity_valid", p.entity_valid, About{});
  f("visible", p.visible, About{});
  f("host_frame_low", p.host_frame_low, About{15});
  f("responses", p.responses, About{});
  f("entity", p.entity, About{});
  f("range_m", p.range_m, About{~0u, p.valid});
}
template <class F>
void fields(LosExtendedResponse& p, F f) {
  f("id", p.id, About{});
  f("valid", p.valid, About{});
  f("entity_valid", p.entity_valid, About{});
  f("range_valid", p.range_valid, About{});
  f("visible", p.visible, About{});
  f("host_frame_low", p.host_frame_low, About{15});
  f("responses", p.responses, About{});
  f("entity", p.entity, About{});
  f("range_m", p.range_m, About{~0u, p.range_valid});
  f("latitude_deg_or_x_m", p.latitude_deg_or_x_m, About{~0u, p.valid});
  f("longitude_deg_or_y_m", p.longitude_deg_or_y_m, About{~0u, p.valid});
  f("altitude_m_or_z_m", p.altitude_m_or_z_m, About{~0u, p.valid});
  f("red", p.red, About{});
  f("green", p.green, About{});
  f("blue", p.blue, About{});
  f("alpha", p.alpha, About{});
  f("material", p.material, About{});
  f("normal_azimuth_deg", p.normal_azimuth_deg, About{~0u, p.valid});
  f("normal_elevation_deg", p.normal_elevation_deg, About{~0u, p.valid});
}

}  // namespace karst::cigi
