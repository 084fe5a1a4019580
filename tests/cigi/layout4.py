# SPDX-License-Identifier: MIT
"""Fields of CIGI 4.0's packets in the order in which they stand, after SISO-STD-013-2014 as the CIGI Host
Emulator 4.0 has it: it shares nothing with karst's tables."""

import struct

# (number, size, fields): a field is (name, format of struct); a list is the bits of a byte, the lowest first,
# (name, width); "" is reserved.
PLACE = [("latitude_deg_or_x_m", "d"), ("longitude_deg_or_y_m", "d"), ("altitude_m_or_z_m", "d")]
ANGLES = [("roll_deg", "f"), ("pitch_deg", "f"), ("yaw_deg", "f")]
SOURCE = [(f"source_{name}", kind) for name, kind in PLACE]
DESTINATION = [(f"destination_{name}", kind) for name, kind in PLACE]
NORMAL = [("normal_azimuth_deg", "f"), ("normal_elevation_deg", "f")]
COMPONENT = [("component", "H"), [("component_class", 6), ("", 2)], ("state", "B"), ("instance", "H"),
             ("", "H"),
             ("", "I")]
WORDS = [(f"word{i}", "I") for i in range(1, 7)]
LAYOUTS = {
    "IgControl": (0, 24, [
        ("version", "B"), ("database", "b"), [("entity_type_substitution", 1), ("", 7)],
        [("mode", 2), ("timestamp_valid", 1), ("smoothing", 1), ("minor", 4)],
        ("host_frame", "I"), ("last_ig_frame", "I"), ("timestamp_10us", "I"), ("", "I")]),
    "EntityPosition": (1, 48, [
        [("attached", 1), ("clamp", 2), ("", 5)], ("", "B"), ("entity", "H"), ("parent", "H"), ("", "H"),
        *ANGLES, *PLACE]),
    "ComponentControl": (3, 40, [*COMPONENT, *WORDS]),
    "ShortComponentControl": (4, 24, [*COMPONENT, *WORDS[:2]]),
    "RateControl": (7, 32, [
        ("entity", "H"), ("part", "B"), [("of_part", 1), ("local", 1), ("", 6)], ("x_m_s", "f"),
        ("y_m_s", "f"),
        ("z_m_s", "f"), ("roll_deg_s", "f"), ("pitch_deg_s", "f"), ("yaw_deg_s", "f")]),
    "CelestialSphereControl": (8, 24, [
        [("ephemeris", 1), ("sun", 1), ("moon", 1), ("stars", 1), ("date_time_valid", 1), ("", 3)], ("", "B"),
        ("hour", "B"), ("minute", "B"), ("second", "f"), ("date_mmddyyyy", "I"),
        ("star_intensity_percent", "f"), ("", "I")]),
    "AtmosphereControl": (9, 32, [
        [("humidity_percent", 7), ("model", 1)], ("", "B"), ("", "H"), ("air_temperature_c", "f"),
        ("visibility_m", "f"), ("horizontal_wind_m_s", "f"), ("vertical_wind_m_s", "f"),
        ("wind_direction_deg", "f"), ("pressure_hpa", "f")]),
    "WeatherControl": (0x0B, 72, [
        ("layer", "B"), ("humidity_percent", "B"),
        [("enabled", 1), ("scud", 1), ("random_winds", 1), ("random_lightning", 1), ("cloud_type", 4)],
        [("scope", 2), ("severity", 3), ("top_scud", 1), ("", 2)], ("entity_or_region", "H"), ("", "H"),
        ("air_temperature_c", "f"), ("visibility_m", "f"), ("scud_percent", "f"), ("coverage_percent", "f"),
        ("base_elevation_m", "f"), ("thickness_m", "f"), ("transition_m", "f"), ("horizontal_wind_m_s", "f"),
        ("vertical_wind_m_s", "f"), ("wind_direction_deg", "f"), ("pressure_hpa", "f"), ("aerosol_g_m3", "f"),
        ("top_scud_percent", "f"), ("top_transition_m", "f"), ("", "I")]),
    "ViewControl": (0x0F, 40, [
        ("group", "B"),
        [("x_valid", 1), ("y_valid", 1), ("z_valid", 1), ("roll_valid", 1), ("pitch_valid", 1),
         ("yaw_valid", 1),
         ("", 2)],
        ("view", "H"), ("entity", "H"), ("", "H"), ("x_m", "f"), ("y_m", "f"), ("z_m", "f"), *ANGLES,
        ("", "I")]),
    "ViewDefinition": (0x14, 40, [
        ("view", "H"), ("group", "B"),
        [("near_valid", 1), ("far_valid", 1), ("left_valid", 1), ("right_valid", 1), ("top_valid", 1),
         ("bottom_valid", 1), ("mirror", 2)],
        [("pixel_replication", 3), ("parallel", 1), ("reorder", 1), ("type", 3)], ("", "B"), ("", "H"),
        ("near_m", "f"), ("far_m", "f"), ("left_deg", "f"), ("right_deg", "f"), ("top_deg", "f"),
        ("bottom_deg", "f"), ("", "I")]),
    "HatHotRequest": (0x17, 40, [
        ("id", "H"), ("entity", "H"), [("type", 2), ("system", 1), ("", 5)], ("update_period", "B"),
        ("", "H"),
        ("", "I"), *PLACE]),
    "LosSegmentRequest": (0x18, 72, [
        ("id", "H"), ("entity", "H"),
        [("extended", 1), ("source", 1), ("destination", 1), ("response", 1), ("destination_entity_valid", 1),
         ("", 3)],
        ("alpha_threshold", "B"), ("destination_entity", "H"), ("update_period", "B"), ("", "B"), ("", "H"),
        *SOURCE, *DESTINATION, ("material_mask", "I"), ("", "I")]),
    "LosVectorRequest": (0x19, 64, [
        ("id", "H"), ("entity", "H"), [("extended", 1), ("source", 1), ("response", 1), ("", 5)],
        ("alpha_threshold", "B"), ("update_period", "B"), ("", "B"), ("", "I"), ("azimuth_deg", "f"),
        ("elevation_deg", "f"), ("minimum_range_m", "f"), ("maximum_range_m", "f"), *SOURCE,
        ("material_mask", "I"), ("", "I")]),
    "EntityControl": (0x25, 16, [
        [("state", 2), ("collision_detection", 1), ("inherit_alpha", 1), ("smoothing", 1),
         ("extended_type", 1),
         ("", 2)],
        ("alpha", "B"), ("entity", "H"), ("kind", "B"), ("domain", "B"), ("type", "H"), ("category", "B"),
        ("subcategory", "B"), ("specific", "B"), ("extra", "B")]),
    "StartOfFrame": (0xFFFF, 24, [
        ("version", "B"), ("database", "b"), ("", "B"),
        [("mode", 2), ("timestamp_valid", 1), ("own_earth_model", 1), ("minor", 4)], ("ig_frame", "I"),
        ("timestamp_10us", "I"), ("last_host_frame", "I"), ("conditions", "H"), ("", "H")]),
    "HatHotResponse": (0x0FFF, 16, [
        [("valid", 1), ("type", 1), ("", 2), ("host_frame_low", 4)], ("", "B"), ("id", "H"),
        ("height_m", "d")]),
    "HatHotExtendedResponse": (0x0FFE, 40, [
        [("valid", 1), ("", 3), ("host_frame_low", 4)], ("", "B"), ("id", "H"), ("hat_m", "d"),
        ("hot_m", "d"),
        ("material", "I"), *NORMAL, ("", "I")]),
    "LosResponse": (0x0FFD, 24, [
        ("id", "H"), ("entity", "H"),
        [("valid", 1), ("entity_valid", 1), ("visible", 1), ("", 1), ("host_frame_low", 4)],
        ("responses", "B"),
        ("", "H"), ("", "I"), ("range_m", "d")]),
    "LosExtendedResponse": (0x0FFC, 64, [
        ("id", "H"), ("entity", "H"),
        [("valid", 1), ("entity_valid", 1), ("range_valid", 1), ("visible", 1), ("host_frame_low", 4)],
        ("responses", "B"), ("", "H"), ("", "I"), ("range_m", "d"), *PLACE, ("red", "B"), ("green", "B"),
        ("blue", "B"), ("alpha", "B"), ("material", "I"), *NORMAL]),
}


def read(name, data, order):
    """The packet's size and its fields; order is struct's sign. What is reserved must be 0."""
    number, size, fields = LAYOUTS[name]
    assert struct.unpack_from(order + "HH", data) == (size, number), name
    at, values = 4, {}

    def add(key, value):
        assert key or value == 0, f"{name}: a reserved field is {value}"
        if key:
            values[key] = value

    for field in fields:
        if isinstance(field, list):
            byte = data[at]
            at += 1
            assert sum(width for _, width in field) == 8
            for key, width in field:
                add(key, byte & ((1 << width) - 1))
                byte >>= width
        else:
            key, kind = field
            add(key, struct.unpack_from(order + kind, data, at)[0])
            at += struct.calcsize(order + kind)
    assert at == size, f"{name}: {at} bytes of {size}"
    if "version" in values:
        assert (values.pop("version"), values.pop("minor")) == (4, 0)
    conditions = values.pop("conditions", None)
    if conditions is not None:
        assert conditions & ~0x0700 == 0
        for i, key in enumerate(("overframing", "paging", "too_much_variable_data")):
            values[key] = conditions >> 8 + i & 1
    return size, values
