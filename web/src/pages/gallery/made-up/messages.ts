/** A robot's messages for the gallery, as ROS 1 serializes them. */

const BEAMS = 90;

type Part = number | string | { readonly real: number } | { readonly single: number } | { readonly octet: number };

/** Parts one behind the other: whole numbers of 32 bits, texts as their letters with their count before them, and what is named by its form. */
function written(parts: readonly Part[]): number[] {
  return parts.flatMap((part) => {
    if (typeof part === "string") return [...written([part.length]), ...new TextEncoder().encode(part)];
    if (typeof part === "number") return [...new Uint8Array(new Uint32Array([part]).buffer)];
    if ("octet" in part) return [part.octet];
    return [...new Uint8Array("single" in part ? new Float32Array([part.single]).buffer : new Float64Array([part.real]).buffer)];
  });
}

const zeros = (count: number): readonly number[] => Array.from({ length: count }, () => 0);
const reals = (numbers: readonly number[]): readonly Part[] => numbers.map((real) => ({ real }));
const singles = (numbers: readonly number[]): readonly Part[] => numbers.map((single) => ({ single }));
const header = (frame: string): readonly Part[] => [1, 1_780_000_000, 0, frame];

export const MADE_ODOMETRY = Uint8Array.from(written([...header("odom"), "base_link", ...reals([0.4, 0.2, 0, 0, 0, Math.sin(0.2), Math.cos(0.2), ...zeros(36 + 6 + 36)])]));
const STEP = (2 * Math.PI) / BEAMS;
const RANGES = Array.from({ length: BEAMS }, (_, at) => Math.min(2 / Math.abs(Math.cos(at * STEP)), 1.4 / Math.abs(Math.sin(at * STEP))));
export const MADE_SCAN = Uint8Array.from(written([...header("base_link"), ...singles([0, STEP * (BEAMS - 1), STEP, 0, 0.1, 0.1, 8]), BEAMS, ...singles(RANGES), 0]));

const SIDE = 32;
/** Looks up along the body's z. */
export const MADE_CAMERA = Uint8Array.from(
  written([...header("base_link"), SIDE, SIDE, "plumb_bob", 0, ...reals([SIDE, 0, SIDE / 2, 0, SIDE, SIDE / 2, 0, 0, 1, ...zeros(9), ...zeros(12)]), 0, 0, 0, 0, 0, 0, { octet: 0 }]),
);
/** A chequered picture. */
export const MADE_PICTURE = Uint8Array.from([
  ...written([...header("base_link"), SIDE, SIDE, "rgb8", { octet: 0 }, 3 * SIDE, 3 * SIDE * SIDE]),
  ...Array.from({ length: SIDE * SIDE }, (_, at) => ((at >> 2) + (at >> 7)) % 2 ? [230, 120, 40] : [40, 90, 160]).flat(),
]);
