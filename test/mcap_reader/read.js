// Reads an MCAP file twice, and prints as JSON the messages of each topic: "stream" from front
// to back as far as it is whole, "index" by the index at its end, or null where there is none.
import { readFileSync } from 'node:fs';
import { McapIndexedReader, McapStreamReader } from '@mcap/core';

const data = readFileSync(process.argv[2]);

class Counts {
  topics = new Map();
  counts = {};

  take(record) {
    if (record.type === 'Channel') this.topics.set(record.id, record.topic);
    if (record.type !== 'Message') return;
    const topic = this.topics.get(record.channelId);
    this.counts[topic] = (this.counts[topic] ?? 0) + 1;
  }
}

function streamed() {
  const reader = new McapStreamReader();
  const found = new Counts();
  reader.append(data);
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) found.take(record);
  return found.counts;
}

async function indexed() {
  const readable = {
    size: async () => BigInt(data.length),
    read: async (offset, length) => data.subarray(Number(offset), Number(offset + length)),
  };
  let reader;
  try {
    reader = await McapIndexedReader.Initialize({ readable });
  } catch {
    return null;
  }
  const found = new Counts();
  for (const channel of reader.channelsById.values()) found.take(channel);
  for await (const message of reader.readMessages()) found.take(message);
  return found.counts;
}

console.log(JSON.stringify({ stream: streamed(), index: await indexed() }));
