#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Others read the packets of karst_cigi_dump as karst means them: tshark's CIGI dissector those of 3.2 and
3.3, every field of every packet and none beside them, in both orders; those of 4.0, which tshark does not
know, a list of the standard's fields in their order (layout4.py). Skipped (77) without tshark."""

import argparse
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import layout4

HOST_PORT, IG_PORT = 8005, 8004
LOOPBACK = 0x7F000001

# Of each packet, tshark's name of it and of its fields where they are not karst's.
PLACE = {"latitude_deg_or_x_m": "lat_xoff", "longitude_deg_or_y_m": "lon_yoff",
         "altitude_m_or_z_m": "alt_zoff"}
SOURCE = {f"source_{name}": f"source_{theirs}" for name, theirs in PLACE.items()}
DESTINATION = {f"destination_{name}": f"destination_{theirs}" for name, theirs in PLACE.items()}
NORMAL = {"normal_azimuth_deg": "normal_vector_azimuth", "normal_elevation_deg": "normal_vector_elevation",
          "material": "material_code", "host_frame_low": "host_frame_number_lsn"}
WORDS = {f"word{i}": f"data_{i}" for i in range(1, 7)}
COMPONENT = {"component": "component_id", "instance": "instance_id", "state": "component_state", **WORDS}
WIND = {"air_temperature_c": "air_temp", "visibility_m": "visibility_range", "humidity_percent": "humidity",
        "horizontal_wind_m_s": "horiz_wind", "vertical_wind_m_s": "vert_wind",
        "wind_direction_deg": "wind_direction", "pressure_hpa": "barometric_pressure"}
ANGLES = {"roll_deg": "roll", "pitch_deg": "pitch", "yaw_deg": "yaw"}
NAMES = {
    "IgControl": ("ig_control", {
        "database": "db_number", "mode": "ig_mode", "smoothing": "extrapolation_enable",
        "host_frame": "host_frame_number", "timestamp_10us": "timestamp",
        "last_ig_frame": "last_ig_frame_number"}),
    "Entity": ("entity_control", {
        "entity": "entity_id", "state": "entity_state", "collision_detection": "coll_det_request",
        "smoothing": "extrapolation_enable", "type": "entity_type", "animation_backward": "animation_dir",
        "animation_loop": "animation_loop_mode", "animation": "animation_state", "attached": "attach_state",
        "clamp": "ground_ocean_clamp", "parent": "parent_id", **ANGLES, **PLACE}),
    "RateControl": ("rate_control", {
        "entity": "entity_id", "part": "part_id", "of_part": "apply_to_part", "local": "coordinate_system",
        "x_m_s": "x_rate", "y_m_s": "y_rate", "z_m_s": "z_rate", "roll_deg_s": "roll_rate",
        "pitch_deg_s": "pitch_rate", "yaw_deg_s": "yaw_rate"}),
    "ComponentControl": ("component_control", COMPONENT),
    "ShortComponentControl": ("short_component_control", COMPONENT),
    "CelestialSphereControl": ("celestial_sphere_control", {
        "ephemeris": "ephemeris_enable", "sun": "sun_enable", "moon": "moon_enable", "stars": "star_enable",
        "date_mmddyyyy": "date", "star_intensity_percent": "star_intensity"}),
    "AtmosphereControl": ("atmosphere_control", {"model": "atmospheric_model_enable", **WIND}),
    "WeatherControl": ("weather_control", {
        "entity_or_region": "entity_region_id", "layer": "layer_id", "enabled": "weather_enable",
        "scud": "scud_enable", "random_winds": "random_winds_enable",
        "random_lightning": "random_lightning_enable", "scud_percent": "scud_frequency",
        "coverage_percent": "coverage", "base_elevation_m": "base_elevation", "thickness_m": "thickness",
        "transition_m": "transition_band", "aerosol_g_m3": "aerosol_concentration", **WIND}),
    "ViewControl": ("view_control", {
        "view": "view_id", "group": "group_id", "entity": "entity_id", "x_valid": "xoff_enable",
        "y_valid": "yoff_enable", "z_valid": "zoff_enable", "roll_valid": "roll_enable",
        "pitch_valid": "pitch_enable", "yaw_valid": "yaw_enable", "x_m": "xoff", "y_m": "yoff", "z_m": "zoff",
        **ANGLES}),
    "ViewDefinition": ("view_def", {
        "view": "view_id", "group": "group_id", "mirror": "mirror_mode", "parallel": "projection_type",
        "type": "view_type", "near_m": "near", "far_m": "far",
        **{f"{side}_valid": f"{side}_enable" for side in ("near", "far", "left", "right", "top", "bottom")},
        **{f"{side}_deg": side for side in ("left", "right", "top", "bottom")}}),
    "HatHotRequest": ("hat_hot_request", {
        "id": "hat_hot_id", "system": "coordinate_system", "entity": "entity_id", **PLACE}),
    "LosSegmentRequest": ("los_segment_request", {
        "id": "los_id", "extended": "type", "source": "source_coord", "destination": "destination_coord",
        "response": "response_coord", "destination_entity_valid": "destination_entity_id_valid",
        "entity": "entity_id", "destination_entity": "destination_entity_id", **SOURCE, **DESTINATION}),
    "LosVectorRequest": ("los_vector_request", {
        "id": "los_id", "extended": "type", "source": "source_coord", "response": "response_coord",
        "alpha_threshold": "alpha", "entity": "entity_id", "azimuth_deg": "azimuth",
        "elevation_deg": "elevation", "minimum_range_m": "min_range", "maximum_range_m": "max_range",
        **SOURCE}),
    "StartOfFrame": ("sof", {
        "database": "db_number", "status": "ig_status", "mode": "ig_mode",
        "own_earth_model": "earth_reference_model", "ig_frame": "ig_frame_number",
        "timestamp_10us": "timestamp", "last_host_frame": "last_host_frame_number"}),
    "HatHotResponse": ("hat_hot_response", {
        "id": "hat_hot_id", "host_frame_low": "host_frame_number_lsn", "height_m": "height"}),
    "HatHotExtendedResponse": ("hat_hot_ext_response", {
        "id": "hat_hot_id", "hat_m": "hat", "hot_m": "hot", **NORMAL}),
    "LosResponse": ("los_response", {
        "id": "los_id", "entity_valid": "entity_id_valid", "host_frame_low": "host_frame_number_lsn",
        "responses": "count", "entity": "entity_id", "range_m": "range"}),
    "LosExtendedResponse": ("3_2_los_ext_response", {
        "id": "los_id", "entity_valid": "entity_id_valid", "responses": "response_count",
        "entity": "entity_id", "range_m": "range", **PLACE, **NORMAL}),
}
# Not karst's fields but of every packet, and of the first one.
HEADER = {"cigi.packet_id", "cigi.packet_size", "cigi.version", "cigi.byte_swap"}


def packets_of(message):
    """(name, fields) of each packet on the wire: 3.x has an entity's control and position in one."""
    packets = []
    for packet in message["packets"]:
        name, fields = packet["name"], dict(packet["fields"])
        if fields.pop("short_form", 0):
            name = "ShortComponentControl"
            fields = {key: value for key, value in fields.items() if key[-1] not in "3456"}
        if name == "EntityPosition" and packets[-1][0] == "EntityControl":
            _, control = packets.pop()
            assert control["entity"] == fields["entity"]
            name, fields = "Entity", {**control, **fields}
        packets.append((name, fields))
    return packets


def write_pcap(path, messages, host):
    """Of the link type Ethernet, UDP over IPv4, without checksums."""
    ports = (HOST_PORT, IG_PORT) if host else (IG_PORT, HOST_PORT)
    with open(path, "wb") as out:
        out.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
        for message in messages:
            data = bytes.fromhex(message["bytes"])
            udp = struct.pack(">HHHH", *ports, 8 + len(data), 0) + data
            ip = struct.pack(">BBHHHBBHII", 0x45, 0, 20 + len(udp), 1, 0, 64, 17, 0, LOOPBACK, LOOPBACK) + udp
            frame = bytes(12) + b"\x08\x00" + ip
            out.write(struct.pack("<IIII", 0, 0, len(frame), len(frame)) + frame)


def dissect(tshark, path):
    """tshark's packets of each message: (name, [field...])."""
    command = [tshark, "-r", path, "-d", f"udp.port=={IG_PORT},cigi", "-T", "pdml"]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    messages = []
    for packet in ElementTree.fromstring(result.stdout):
        names = [proto.get("name") for proto in packet]
        assert names[-1] == "cigi", f"tshark says {names}"
        messages.append([(field.get("name"), list(field)) for field in packet[-1] if len(field) > 0])
    return messages


def same(field, value, order):
    """Whether tshark shows the value; floats, which it rounds, by their bytes too."""
    size, show, raw = int(field.get("size")), field.get("show"), field.get("value")
    if ":" in show:
        return raw == struct.pack(order + "I", value).hex()
    if isinstance(value, float) or "." in show or "e" in show:
        exact = struct.pack(order + ("f" if size == 4 else "d"), value).hex()
        return raw == exact and abs(float(show) - value) <= 1e-5 * abs(value)
    if raw == bytes(size).hex() and size in (4, 8):
        return value == 0 and float(show) == 0
    if float(show) != value:
        return False
    return True


def check_by_tshark(tshark, messages, order, work, host, version):
    write_pcap(work / "messages.pcap", messages, host)
    count = 0
    dissected = dissect(tshark, work / "messages.pcap")
    assert len(dissected) == len(messages)
    for message, theirs in zip(messages, dissected):
        ours = packets_of(message)
        assert [f"cigi.{NAMES[name][0]}" for name, _ in ours] == [name for name, _ in theirs], theirs
        for (name, fields), (_, shown) in zip(ours, theirs):
            packet, names = NAMES[name]
            left = {field.get("name"): field for field in shown}
            assert len(left) == len(shown), f"{name}: a field twice"
            for key, value in fields.items():
                if version == "2" and key == "smoothing":
                    continue  # 3.2 has it not
                field = left.pop(f"cigi.{packet}.{names.get(key, key)}", None)
                assert field is not None, f"{name}.{key}: tshark shows {sorted(left)}"
                assert same(field, value, order), f"{name}.{key} is {value}: {field.attrib}"
                count += 1
            minor = left.pop(f"cigi.{packet}.minor_version", None)
            assert minor is None or minor.get("show") == version
            assert set(left) <= HEADER, f"{name}: karst does not write {sorted(set(left) - HEADER)}"
    return count


def check_by_layout(messages, order):
    count = 0
    for message in messages:
        data = bytes.fromhex(message["bytes"])
        for packet in message["packets"]:
            name, fields = packet["name"], dict(packet["fields"])
            if fields.pop("short_form", 0):
                name = "ShortComponentControl"
                fields = {key: value for key, value in fields.items() if key[-1] not in "3456"}
            size, read = layout4.read(name, data, order)
            assert read == fields, f"{name}: {read}\nis not {fields}"
            data = data[size:]
            count += len(fields)
        assert not data
    return count


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--dump", required=True)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--messages", type=int, default=50)
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)

    def messages(major, minor, order, speaker):
        command = [options.dump, major, minor, order, speaker, str(options.messages)]
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        return [json.loads(line) for line in text.splitlines()]

    tshark = shutil.which("tshark")
    for order, sign in (("little", "<"), ("big", ">")):
        for speaker in ("host", "ig"):
            count = check_by_layout(messages("4", "0", order, speaker), sign)
            print(f"4.0, {order}, {speaker}: {count} fields as the standard has them")
            if tshark is None:
                continue
            for minor in ("2", "3"):
                count = check_by_tshark(tshark, messages("3", minor, order, speaker), sign, options.work,
                                        speaker == "host", minor)
                print(f"3.{minor}, {order}, {speaker}: tshark shows {count} fields as they were written")
    if tshark is None:
        print("skipped: no tshark (apt-get install tshark)")
        return 77
    return 0


if __name__ == "__main__":
    sys.exit(main())
