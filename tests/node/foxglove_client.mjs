// Follows topics of a Foxglove server, and sends commands if asked to; each line is JSON.
import WebSocket from "ws";
import protocol from "@foxglove/ws-protocol";
import { parse } from "@foxglove/rosmsg";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";

const [url, wanted, asked] = process.argv.slice(2).map((one, place) => (place ? JSON.parse(one) : one));
// Foxglove's newer servers know this name of the protocol only.
const client = new protocol.FoxgloveClient({ ws: new WebSocket(url, ["foxglove.sdk.v1"]) });
const readers = new Map();
const missing = new Map(Object.entries(wanted));
const services = new Map();

function tell(message) {
  console.log(JSON.stringify(message, plain));
}

function plain(key, value) {
  if (typeof value === "bigint") return Number(value);
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}

function endWhenDone() {
  if (missing.size === 0) client.close();
}

function toCdr(type, schema, message) {
  const definitions = parse(schema, { ros2: true });
  return new MessageWriter(definitions).writeMessage(message);
}

client.on("error", (error) => {
  console.error(error);
  process.exit(1);
});
client.on("serverInfo", (info) => tell({ info }));
client.on("status", ({ message }) => {
  tell({ status: message });
  missing.delete("status");
  endWhenDone();
});
client.on("advertise", (channels) => {
  for (const channel of channels) {
    tell({ channel: channel.topic, type: channel.schemaName, encoding: channel.encoding });
    if (!missing.has(channel.topic)) continue;
    const reader = new MessageReader(parse(channel.schema, { ros2: true }));
    readers.set(client.subscribe(channel.id), { topic: channel.topic, reader });
  }
});
client.on("advertiseServices", (offered) => {
  for (const service of offered) services.set(service.name, service);
  if (asked?.service) call(services.get(asked.service.name));
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, reader } = readers.get(subscriptionId);
  tell({ topic, log_time: String(timestamp), message: reader.readMessage(data) });
  const rest = (missing.get(topic) ?? 1) - 1;
  if (rest > 0) missing.set(topic, rest);
  else missing.delete(topic);
  endWhenDone();
});
client.on("serviceCallResponse", () => answered(true));
client.on("serviceCallFailure", ({ message }) => answered(false, message));
client.on("open", () => {
  if (!asked?.publish) return;
  const { topic, schemaName, schema, message } = asked.publish;
  const channel = client.advertise({ topic, encoding: "cdr", schemaName, schemaEncoding: "ros2msg", schema });
  client.sendMessage(channel, toCdr(schemaName, schema, message));
});

function call(service) {
  const { schemaName, schema, encoding } = service.request;
  const payload = toCdr(schemaName, schema, asked.service.message);
  client.sendServiceCallRequest({
    serviceId: service.id,
    callId: 1,
    encoding,
    data: new DataView(payload.buffer, payload.byteOffset, payload.byteLength),
  });
}

function answered(result, words) {
  tell({ service: result, words });
  missing.delete("service");
  endWhenDone();
}
