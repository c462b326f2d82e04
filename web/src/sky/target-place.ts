/** Where a request's target stands. Pure. */

import { msg, str } from "@lit/localize";
import { fixedText } from "../format/number.js";
import type { RequestShape } from "../generated/api.js";
import { precessedFromJ2000 } from "./coordinates.js";
import type { SkyPlace } from "./request-visibility.js";
import { moonAt } from "./sun-and-moon.js";

const YEAR_MS = 365.25 * 86_400_000;
const J2000_MS = Date.UTC(2000, 0, 1, 12);
const DEGREES_PER_MAS = 1 / 3_600_000;

/** Null for planets, whose places a page does not work out, and for frames that need no sky. */
export function targetPlace(target: RequestShape["target"]): SkyPlace | null {
  if (target === null) return null;
  switch (target.type) {
    case "FIXED":
      return { fixed: { alt: target.altitude, az: target.azimuth } };
    case "SOLAR_SYSTEM":
      return target.body === "moon" ? { at: moonAt } : null;
    case "ICRS": {
      const { ra, dec, proper_motion_ra: motionRa = 0, proper_motion_dec: motionDec = 0, epoch = 2000 } = target;
      return {
        at: (ms) => {
          const years = 2000 + (ms - J2000_MS) / YEAR_MS - epoch;
          const east = (motionRa * years * DEGREES_PER_MAS) / Math.max(0.01, Math.cos((dec * Math.PI) / 180));
          return precessedFromJ2000({ ra: (ra + east) / 15, dec: dec + motionDec * years * DEGREES_PER_MAS }, ms);
        },
      };
    }
  }
}

/** What a target is called; its coordinates where nobody named it. */
export function targetText(target: RequestShape["target"]): string {
  if (target === null) return msg("no target");
  if (target.name !== undefined && target.name !== "") return target.name;
  switch (target.type) {
    case "FIXED":
      return msg(str`altitude ${fixedText(target.altitude, 1)}°, azimuth ${fixedText(target.azimuth, 1)}°`);
    case "SOLAR_SYSTEM":
      return target.body.charAt(0).toUpperCase() + target.body.slice(1);
    case "ICRS":
      return msg(str`${fixedText(target.ra / 15, 4)} h ${fixedText(target.dec, 3)}°`);
  }
}
