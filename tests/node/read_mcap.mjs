// Reads an MCAP file with the packages that Foxglove is made of; each message is a line of JSON.
import { readFileSync } from "node:fs";
import { McapIndexedReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";

const data = new Uint8Array(readFileSync(process.argv[2]));
const readable = {
  size: async () => BigInt(data.length),
  read: async (offset, size) => data.subarray(Number(offset), Number(offset + size)),
};
const reader = await McapIndexedReader.Initialize({
  readable,
  decompressHandlers: await loadDecompressHandlers(),
});

/** Numbers that JSON does not have are told by name. */
function plain(key, value) {
  if (typeof value === "bigint") return Number(value);
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}

const decoders = new Map();
for (const [id, channel] of reader.channelsById) {
  const schema = reader.schemasById.get(channel.schemaId);
  if (schema.encoding !== "ros2msg" || channel.messageEncoding !== "cdr") throw new Error("not ROS 2");
  const definition = parse(new TextDecoder().decode(schema.data), { ros2: true });
  decoders.set(id, { topic: channel.topic, type: schema.name, reader: new MessageReader(definition) });
}
for await (const one of reader.readMessages()) {
  const { topic, type, reader: decoder } = decoders.get(one.channelId);
  const message = decoder.readMessage(one.data);
  console.log(JSON.stringify({ topic, type, log_time: String(one.logTime), message }, plain));
}
