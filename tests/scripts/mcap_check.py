"""Reads a session with PyPI mcap and mcap-protobuf-support and tells what is in it, as JSON.

    python tests/scripts/mcap_check.py SESSION.mcap

Every message of every channel is decoded by the schema that is in the file. Schemas that are called
foxglove.* must be those that Foxglove publishes (PyPI foxglove-schemas-protobuf), field by field.
"""

import importlib
import json
import sys

from google.protobuf import descriptor_pb2
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def fields(message):
    """What readers go by: names, numbers, kinds."""
    return sorted(
        (f.name, f.number, f.type, f.label, f.type_name, f.proto3_optional) for f in message.field
    )


def check_foxglove(schemas):
    """Compares every message of the package foxglove with the one that Foxglove publishes."""
    checked = set()
    for schema in schemas:
        files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
        for file in files.file:
            if file.package != "foxglove":
                continue
            for message in file.message_type:
                if message.name in checked:
                    continue
                module = importlib.import_module(f"foxglove_schemas_protobuf.{message.name}_pb2")
                published = descriptor_pb2.FileDescriptorProto()
                module.DESCRIPTOR.CopyToProto(published)
                theirs = {m.name: m for m in published.message_type}[message.name]
                assert fields(message) == fields(theirs), f"foxglove.{message.name} is another"
                checked.add(message.name)
    return len(checked)


def main(path):
    """Prints what is in the session."""
    channels, red, hand, picture = {}, [], [], {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        foxglove = check_foxglove(summary.schemas.values())
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            found = channels.setdefault(channel.topic, {"schema": schema.name, "decoded": 0})
            found["decoded"] += 1
            assert decoded.DESCRIPTOR.full_name == schema.name
            if channel.topic == "/left/observations":
                red.append([decoded.balls[0].u, decoded.balls[0].v])
            elif channel.topic == "/hand":
                hand.append(list(decoded.pose.translation))
            elif channel.topic == "/left/image":
                size = [decoded.width, decoded.height, decoded.encoding, decoded.step]
                assert len(decoded.data) == decoded.step * decoded.height
                assert decoded.timestamp.ToNanoseconds() == message.log_time
                picture = {"size": size, "last": list(decoded.data[-3:])}
        counts = summary.statistics.channel_message_counts
        for number, channel in summary.channels.items():
            found = channels.get(channel.topic)
            assert found and found["decoded"] == counts[number], f"{channel.topic}: {counts[number]}"
    told = {"channels": channels, "red": red, "hand": hand, "picture": picture, "foxglove": foxglove}
    json.dump(told, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
