/** Reads a PMTiles file (version 3) by ranges: header, directories, tiles. By its public specification. */

/** Bytes from an offset on; fewer at the end of the file. */
export type ReadRange = (offset: number, length: number) => Promise<ArrayBuffer>;

export type PmtilesKind = "vector" | "image/png" | "image/jpeg" | "image/webp" | "image/avif" | "unknown";

interface PmtilesEntry {
  readonly id: number;
  readonly offset: number;
  readonly length: number;
  /** Tiles in turn that are the same; 0 of a directory below. */
  readonly run: number;
}

export interface PmtilesHeader {
  readonly kind: PmtilesKind;
  readonly minZoom: number;
  readonly maxZoom: number;
  /** ° */
  readonly west: number;
  readonly south: number;
  readonly east: number;
  readonly north: number;
}

const HEADER_BYTES = 127;
const KINDS: Readonly<Record<number, PmtilesKind>> = { 1: "vector", 2: "image/png", 3: "image/jpeg", 4: "image/webp", 5: "image/avif" };
/** Directories lie below each other three deep at the most. */
const DEPTH = 4;
/** Directories that are kept. */
const MOST_KEPT = 64;
const MOST_ENTRIES = 1_000_000;

/** The number of a tile: by zoom, and in each along Hilbert's curve. */
export function tileNumber(z: number, x: number, y: number): number {
  let number = (4 ** z - 1) / 3;
  let [column, row] = [x, y];
  for (let side = 2 ** (z - 1); side >= 1; side /= 2) {
    const [right, below] = [Math.floor(column / side) % 2, Math.floor(row / side) % 2];
    number += side * side * ((3 * right) ^ below);
    if (below === 0) {
      if (right === 1) [column, row] = [side - 1 - (column % side), side - 1 - (row % side)];
      [column, row] = [row, column];
    }
  }
  return number;
}

/** @throws RangeError where it is none */
export function readDirectory(data: ArrayBuffer): PmtilesEntry[] {
  const bytes = new Uint8Array(data);
  let at = 0;
  const next = (): number => {
    let [value, scale] = [0, 1];
    for (;;) {
      const byte = bytes[at++];
      if (byte === undefined || scale > 2 ** 53) throw new RangeError("the map's directory is cut off");
      value += (byte % 128) * scale;
      if (byte < 128) return value;
      scale *= 128;
    }
  };
  const count = next();
  if (count > MOST_ENTRIES) throw new RangeError("the map's directory is too long");
  const column = (): number[] => Array.from({ length: count }, next);
  let id = 0;
  const ids = column().map((step) => (id += step));
  const [runs, lengths] = [column(), column()];
  let end = 0;
  return column().map((said, i): PmtilesEntry => {
    const length = lengths[i] ?? 0;
    // Nothing said: right behind the one before.
    const offset = said === 0 ? end : said - 1;
    end = offset + length;
    return { id: ids[i] ?? 0, offset, length, run: runs[i] ?? 0 };
  });
}

/** The entry that has a tile, or the directory in which it may be. */
export function findEntry(entries: readonly PmtilesEntry[], id: number): PmtilesEntry | null {
  let [low, high] = [0, entries.length];
  while (low < high) {
    const middle = (low + high) >>> 1;
    if ((entries[middle]?.id ?? 0) <= id) low = middle + 1;
    else high = middle;
  }
  const entry = entries[low - 1];
  return entry !== undefined && (entry.run === 0 || id < entry.id + entry.run) ? entry : null;
}

/** 1: as it is, 2: gzip. */
async function unpacked(data: ArrayBuffer, compression: number): Promise<ArrayBuffer> {
  if (compression === 0 || compression === 1) return data;
  if (compression !== 2) throw new RangeError("the map is compressed in a way that browsers do not read; gzip is");
  return new Response(new Blob([data]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

export class PmtilesFile {
  private readonly kept = new Map<number, Promise<PmtilesEntry[]>>();

  private constructor(
    private readonly read: ReadRange,
    private readonly view: DataView,
    readonly header: PmtilesHeader,
  ) {}

  /** @throws RangeError where it is none */
  static async open(read: ReadRange): Promise<PmtilesFile> {
    const data = await read(0, HEADER_BYTES);
    const view = new DataView(data);
    if (data.byteLength < HEADER_BYTES || new TextDecoder().decode(data.slice(0, 7)) !== "PMTiles" || view.getUint8(7) !== 3) {
      throw new RangeError("it is no PMTiles file of version 3");
    }
    const degrees = (at: number): number => view.getInt32(at, true) / 1e7;
    return new PmtilesFile(read, view, {
      kind: KINDS[view.getUint8(99)] ?? "unknown",
      minZoom: view.getUint8(100),
      maxZoom: view.getUint8(101),
      west: degrees(102),
      south: degrees(106),
      east: degrees(110),
      north: degrees(114),
    });
  }

  /** What it says of itself, as JSON has it. */
  async metadata(): Promise<unknown> {
    const data = await this.read(this.number(24), this.number(32));
    return JSON.parse(new TextDecoder().decode(await unpacked(data, this.view.getUint8(97))));
  }

  /** A tile; null where the file has none. */
  async tile(z: number, x: number, y: number): Promise<ArrayBuffer | null> {
    const id = tileNumber(z, x, y);
    let [offset, length] = [this.number(8), this.number(16)];
    for (let depth = 0; depth < DEPTH; depth++) {
      const entry = findEntry(await this.directory(offset, length), id);
      if (entry === null || entry.length === 0) return null;
      if (entry.run > 0) return unpacked(await this.read(this.number(56) + entry.offset, entry.length), this.view.getUint8(98));
      [offset, length] = [this.number(40) + entry.offset, entry.length];
    }
    throw new RangeError("the map's directories lead nowhere");
  }

  private directory(offset: number, length: number): Promise<PmtilesEntry[]> {
    const known = this.kept.get(offset);
    if (known !== undefined) return known;
    if (this.kept.size >= MOST_KEPT) this.kept.clear();
    const found = this.read(offset, length).then(async (data) => readDirectory(await unpacked(data, this.view.getUint8(97))));
    this.kept.set(offset, found);
    found.catch(() => {
      // The next asker tries again.
      this.kept.delete(offset);
    });
    return found;
  }

  private number(at: number): number {
    return Number(this.view.getBigUint64(at, true));
  }
}

/** Ranges of a file at an address. */
export function rangesOf(url: string, fetcher: typeof fetch = fetch.bind(globalThis)): ReadRange {
  return async (offset, length) => {
    const answer = await fetcher(url, { headers: { range: `bytes=${String(offset)}-${String(offset + length - 1)}`, "talaia-background": "1" } });
    if (answer.status !== 206) throw new Error(`the hub answers ${String(answer.status)}`);
    return answer.arrayBuffer();
  };
}
