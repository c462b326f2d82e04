import { describe, expect, it } from "vitest";
import { fetchTimes, pictureTimes, tablesEndByte } from "../../src/wire/mp4-times.js";

function box(kind: string, ...parts: readonly Uint8Array[]): Uint8Array {
  const size = 8 + parts.reduce((sum, part) => sum + part.length, 0);
  const made = new Uint8Array(size);
  new DataView(made.buffer).setUint32(0, size);
  made.set(new TextEncoder().encode(kind), 4);
  let at = 8;
  for (const part of parts) {
    made.set(part, at);
    at += part.length;
  }
  return made;
}

function words(...numbers: readonly number[]): Uint8Array {
  const made = new DataView(new ArrayBuffer(4 * numbers.length));
  numbers.forEach((number, at) => {
    made.setUint32(4 * at, number);
  });
  return new Uint8Array(made.buffer);
}

/** A film with so many pictures at these distances; its scale is a millionth of a second. */
function movie(steps: readonly (readonly [count: number, step: number])[], padding = 0): Uint8Array {
  const header = box("mdhd", words(0, 0, 0, 1_000_000, 0, 0));
  const table = box("stts", words(0, steps.length, ...steps.flat()));
  const media = box("mdia", header, box("hdlr"), box("minf", box("vmhd"), box("stbl", box("stsd"), table)));
  const tables = box("moov", box("mvhd"), box("free", new Uint8Array(padding)), box("trak", box("tkhd"), media));
  const whole = [box("ftyp", words(1, 2)), tables, box("mdat", new Uint8Array(500))];
  return Uint8Array.from(whole.flatMap((bytes) => [...bytes]));
}

function view(data: Uint8Array): DataView {
  return new DataView(data.buffer, data.byteOffset, data.byteLength);
}

describe("the tables of a film", () => {
  it("say when each picture is shown", () => {
    expect([...pictureTimes(view(movie([[2, 40_000], [1, 900_000], [1, 33_000]])))]).toEqual([0, 40_000, 80_000, 980_000]);
  });

  it("are found wherever they end, and asked for in two steps when they are long", async () => {
    const short = movie([[3, 10]]);
    expect(tablesEndByte(view(short))).toBe(short.length - 508);
    const long = movie([[5, 20]], 100_000);
    const asked: string[] = [];
    const fetcher = (_path: RequestInfo | URL, init?: RequestInit): Promise<Response> => {
      const range = new Headers(init?.headers).get("range") ?? "";
      asked.push(range);
      const [from = 0, to = 0] = range.replace("bytes=", "").split("-").map(Number);
      return Promise.resolve(new Response(long.slice(from, to + 1), { status: 206 }));
    };
    expect([...(await fetchTimes("/x", new AbortController().signal, fetcher))]).toEqual([0, 20, 40, 60, 80]);
    expect(asked).toEqual(["bytes=0-65535", `bytes=0-${String(long.length - 509)}`]);
  });

  it("are refused where they make no sense", () => {
    const whole = movie([[3, 10]]);
    expect(() => pictureTimes(view(whole.slice(0, 60)))).toThrow(RangeError);
    expect(() => pictureTimes(view(movie([[4e9, 1]])))).toThrow(RangeError);
    expect(tablesEndByte(view(box("mdat", words(1))))).toBe(0);
    // Whatever bytes come: an answer or a refusal, and never without end.
    for (let seed = 1; seed < 400; seed++) {
      const noise = whole.map((byte, at) => ((at * seed * 2654435761) % 97 === 0 ? (byte ^ seed) & 255 : byte));
      try {
        expect(pictureTimes(view(noise)).length).toBeLessThan(10_000_001);
      } catch (error) {
        expect(error).toBeInstanceOf(RangeError);
      }
    }
  });
});
