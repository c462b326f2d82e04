/** A robot's messages for the gallery, as ROS 1 serializes them. */

const BEAMS = 90;

/** Written one behind the other. */
function packed(frame: string, child: string | null, kind: "float32" | "float64", numbers: readonly number[], ranges: readonly number[] = []): Uint8Array {
  const bytes: number[] = [];
  const add = (size: number, write: (view: DataView) => void): void => {
    const view = new DataView(new ArrayBuffer(size));
    write(view);
    bytes.push(...new Uint8Array(view.buffer));
  };
  const whole = (value: number): void => {
    add(4, (view) => {
      view.setUint32(0, value, true);
    });
  };
  const text = (value: string): void => {
    whole(value.length);
    bytes.push(...new TextEncoder().encode(value));
  };
  const real = (value: number): void => {
    if (kind === "float64") add(8, (view) => { view.setFloat64(0, value, true); });
    else add(4, (view) => { view.setFloat32(0, value, true); });
  };
  [1, 1_780_000_000, 0].forEach(whole);
  text(frame);
  if (child !== null) text(child);
  numbers.forEach(real);
  if (child === null) {
    whole(ranges.length);
    ranges.forEach(real);
    whole(0);
  }
  return Uint8Array.from(bytes);
}

const zeros = (count: number): readonly number[] => Array.from({ length: count }, () => 0);
export const MADE_ODOMETRY = packed("odom", "base_link", "float64", [0.4, 0.2, 0, 0, 0, Math.sin(0.2), Math.cos(0.2), ...zeros(36 + 6 + 36)]);
const STEP = (2 * Math.PI) / BEAMS;
export const MADE_SCAN = packed(
  "base_link",
  null,
  "float32",
  [0, STEP * (BEAMS - 1), STEP, 0, 0.1, 0.1, 8],
  Array.from({ length: BEAMS }, (_, at) => Math.min(2 / Math.abs(Math.cos(at * STEP)), 1.4 / Math.abs(Math.sin(at * STEP)))),
);

/** Numbers and texts one behind the other; each text as its letters with their count before them. */
function written(parts: readonly (number | string | { readonly real: number } | { readonly octet: number })[]): number[] {
  return parts.flatMap((part) => {
    if (typeof part === "string") return [...written([part.length]), ...new TextEncoder().encode(part)];
    if (typeof part === "number") return [...new Uint8Array(new Uint32Array([part]).buffer)];
    return "octet" in part ? [part.octet] : [...new Uint8Array(new Float64Array([part.real]).buffer)];
  });
}

const SIDE = 32;
const HEADER = [1, 1_780_000_000, 0, "base_link"] as const;
const reals = (numbers: readonly number[]): { readonly real: number }[] => numbers.map((real) => ({ real }));
/** Looks up along the body's z. */
export const MADE_CAMERA = Uint8Array.from(
  written([...HEADER, SIDE, SIDE, "plumb_bob", 0, ...reals([SIDE, 0, SIDE / 2, 0, SIDE, SIDE / 2, 0, 0, 1, ...zeros(9), ...zeros(12)]), 0, 0, 0, 0, 0, 0, { octet: 0 }]),
);
/** A chequered picture. */
export const MADE_PICTURE = Uint8Array.from([
  ...written([...HEADER, SIDE, SIDE, "rgb8", { octet: 0 }, 3 * SIDE, 3 * SIDE * SIDE]),
  ...Array.from({ length: SIDE * SIDE }, (_, at) => ((at >> 2) + (at >> 7)) % 2 ? [230, 120, 40] : [40, 90, 160]).flat(),
]);
