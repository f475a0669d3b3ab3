"""Reads an MCAP log with mcap, mcap-ros2-support and rosbags, which share no code with this project, and prints what each of them saw."""

import json
import math
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

path = Path(sys.argv[1])

topics = {}
with path.open("rb") as stream:
    reader = make_reader(stream, validate_crcs=True)
    summary = reader.get_summary()
    metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    profile = reader.get_header().profile
    last = 0
    ordered = True
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        topic = topics.setdefault(channel.topic, {"schema": schema.name, "encoding": schema.encoding, "messages": 0, "last": 0, "monotone": True})
        topic["messages"] += 1
        topic["monotone"] = topic["monotone"] and message.log_time >= topic["last"]
        topic["last"] = message.log_time
        ordered = ordered and message.log_time >= last
        last = message.log_time
for topic in topics.values():
    del topic["last"]

ros2 = {}
frames = set()
with path.open("rb") as stream:
    for schema, channel, message, decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
        ros2[channel.topic] = ros2.get(channel.topic, 0) + 1
        if channel.topic == "/odom":
            frames.add((decoded.header.frame_id, decoded.child_frame_id))
            q = decoded.pose.pose.orientation
            heading = 2.0 * math.atan2(q.z, q.w)
            stamp = decoded.header.stamp.sec * 1_000_000_000 + decoded.header.stamp.nanosec
            assert stamp == message.log_time, "header stamp and log time differ"
        if channel.topic == "/joint_states":
            names = list(decoded.name)
        if channel.topic == "/tf":
            frames.add((decoded.transforms[0].header.frame_id, decoded.transforms[0].child_frame_id))

bags = {}
with AnyReader([path]) as reader:
    for connection, _, raw in reader.messages():
        decoded = reader.deserialize(raw, connection.msgtype)
        bags[connection.topic] = bags.get(connection.topic, 0) + 1

print(json.dumps({
    "profile": profile,
    "statistics": summary.statistics.message_count,
    "chunk_indexes": len(summary.chunk_indexes),
    "ordered": ordered,
    "metadata": metadata,
    "topics": topics,
    "ros2": ros2,
    "rosbags": bags,
    "frames": sorted(frames),
    "joints": names,
    "final_heading_deg": math.degrees(heading),
}))
