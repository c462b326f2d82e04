/** What must hold while a request is observed, in words. Pure. */

import { msg, str } from "@lit/localize";
import { formatMoment } from "../../format/julian-date.js";
import { roundText } from "../../format/number.js";
import type { ConstraintsShape } from "../../generated/api.js";

const DAY_S = 86_400;

/** All that is not as lax as it can be. */
export function constraintsText(constraints: ConstraintsShape): string {
  const { min_altitude: altitude = 15, max_airmass: airmass = 10, min_moon_distance: moon = 0, max_moon_illumination: lit = 1, max_sun_altitude: sun = -12 } = constraints;
  const { max_hour_angle: hours, max_seeing: seeing, max_clouds: clouds, phase } = constraints;
  const parts = [
    msg(str`above ${String(altitude)}°`),
    msg(str`Sun below ${String(sun).replace("-", "−")}°`),
    airmass < 10 ? msg(str`airmass below ${String(airmass)}`) : "",
    moon > 0 ? msg(str`${String(moon)}° from the Moon`) : "",
    lit < 1 ? msg(str`Moon lit less than ${roundText(lit * 100, 6)} %`) : "",
    hours == null ? "" : msg(str`within ${String(hours)} h of the meridian`),
    seeing == null ? "" : msg(str`seeing below ${String(seeing)}″`),
    clouds == null ? "" : msg(str`clouds below ${String(clouds)} %`),
    phase == null
      ? ""
      : msg(str`phase ${String(phase.start)} to ${String(phase.end)} of ${roundText(phase.period_s / DAY_S, 9)} days from ${formatMoment(phase.epoch_us)}`),
  ];
  return parts.filter(Boolean).join(", ");
}

/** How it moves among the stars, with the epoch of its coordinates; empty where it does not. */
export function motionText({ proper_motion_ra: ra = 0, proper_motion_dec: dec = 0, epoch = 2000 }: { readonly proper_motion_ra?: number; readonly proper_motion_dec?: number; readonly epoch?: number }): string {
  if (ra === 0 && dec === 0) return epoch === 2000 ? "" : msg(str`, epoch ${String(epoch)}`);
  return msg(str`, moving ${String(ra).replace("-", "−")} and ${String(dec).replace("-", "−")} mas a year, epoch ${String(epoch)}`);
}
