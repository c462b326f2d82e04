/**
 * When each picture of an MP4 file is shown, from the tables at its beginning (ISO/IEC 14496-12).
 * A film's pictures come when they come: only these tables know how far one is from the next.
 */

/** Where a box lies in the bytes at hand; its end may lie beyond them. */
interface Mp4Box {
  readonly kind: string;
  readonly begin: number;
  readonly end: number;
}

const WORD = 4;
/** Files of ours have fewer pictures than this; what says more is broken. */
const MOST_PICTURES = 10_000_000;

/** How many bytes from the beginning hold the tables; 0 where they do not stand in front. */
export function tablesEndByte(data: DataView): number {
  for (const { kind, end } of mp4Boxes(data, 0, data.byteLength)) {
    if (kind === "moov") return end;
    if (kind === "mdat") return 0;
    if (end > data.byteLength) return 0;
  }
  return 0;
}

/**
 * Times of all pictures (µs from the first), rising.
 *
 * @throws RangeError when the tables are not there, not whole, or make no sense
 */
export function pictureTimes(data: DataView): Float64Array {
  const media = boxAt(data, ["moov", "trak", "mdia"]);
  const header = onlyBox(data, media, "mdhd");
  const scale = data.getUint32(header.begin + (data.getUint8(header.begin) === 1 ? 5 : 3) * WORD);
  const steps = boxAt(data, ["minf", "stbl", "stts"], media);
  const rows = data.getUint32(steps.begin + WORD);
  if (scale === 0 || steps.begin + 2 * WORD * (rows + 1) > steps.end) throw new RangeError("the film's tables are broken");
  const times: number[] = [];
  let ticks = 0;
  for (let row = 0; row < rows; row++) {
    const at = steps.begin + 2 * WORD * (row + 1);
    const [count, step] = [data.getUint32(at), data.getUint32(at + WORD)];
    if (times.length + count > MOST_PICTURES) throw new RangeError("the film's tables are broken");
    for (let number = 0; number < count; number++) {
      times.push((ticks * 1e6) / scale);
      ticks += step;
    }
  }
  return Float64Array.from(times);
}

function boxAt(data: DataView, path: readonly string[], from?: Mp4Box): Mp4Box {
  let box = from ?? { kind: "", begin: 0, end: data.byteLength };
  for (const kind of path) box = onlyBox(data, box, kind);
  return box;
}

function onlyBox(data: DataView, within: Mp4Box, kind: string): Mp4Box {
  for (const box of mp4Boxes(data, within.begin, within.end)) {
    if (box.kind === kind && box.end <= data.byteLength) return box;
  }
  throw new RangeError(`the film has no ${kind}`);
}

function* mp4Boxes(data: DataView, begin: number, end: number): Generator<Mp4Box> {
  let at = begin;
  while (at + 2 * WORD <= Math.min(end, data.byteLength)) {
    let size = data.getUint32(at);
    const kind = String.fromCharCode(...[4, 5, 6, 7].map((number) => data.getUint8(at + number)));
    let head = 2 * WORD;
    if (size === 1) {
      if (at + 4 * WORD > data.byteLength) return;
      size = Number(data.getBigUint64(at + head));
      head = 4 * WORD;
    } else if (size === 0) {
      size = end - at;
    }
    if (size < head) return;
    yield { kind, begin: at + head, end: at + size };
    at += size;
  }
}

/** The tables stand in this much of a short film; of a longer one the rest is asked for. */
const FIRST_BYTES = 64 * 1024;
/** More than any film's tables take: 16 bytes for each picture, and some. */
const MOST_BYTES = 64 * 1024 * 1024;

/** Reads a film's tables from where it is. Rejects where they cannot be had. */
export async function fetchTimes(path: string, signal: AbortSignal, fetcher: typeof fetch = fetch): Promise<Float64Array> {
  const fetchBytes = async (bytes: number): Promise<DataView> => {
    const answer = await fetcher(path, { headers: { range: `bytes=0-${String(bytes - 1)}` }, signal });
    if (!answer.ok) throw new RangeError(`the hub answered ${String(answer.status)}`);
    return new DataView(await answer.arrayBuffer());
  };
  let data = await fetchBytes(FIRST_BYTES);
  const end = tablesEndByte(data);
  if (end === 0 || end > MOST_BYTES) throw new RangeError("the film's tables do not stand in front");
  if (end > data.byteLength) data = await fetchBytes(end);
  return pictureTimes(data);
}
