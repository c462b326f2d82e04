/** What to tell the driver. */

import { msg, str } from "@lit/localize";
import type { HaltReason } from "./drive-machine.js";

const HALTS: Readonly<Record<HaltReason, string>> = {
  released: "",
  "stop key": msg("Halted with the S key."),
  cancelled: msg("Halted: the press was interrupted. Press again to continue."),
  blur: msg("Halted: this window lost the focus. Click into it and press again."),
  hidden: msg("Halted and control given back: this page was out of sight."),
  "gamepad lost": msg("Halted: the gamepad is gone."),
  dialog: msg("Halted: a question was open."),
  silent: msg("Halted: the gateway has been silent for a second. Press again once it answers."),
  freed: "",
  "lease lost": msg("Halted: control is no longer yours."),
  offline: msg("Not connected. The gateway brings the vehicle to rest by itself."),
  stop: msg("Halted: STOP is on."),
  interlock: msg("Halted: an interlock locks driving."),
};

/** Why driving ended; empty where there is nothing to explain. */
export function haltWords(why: HaltReason | null): string {
  return why === null ? "" : HALTS[why];
}

/**
 * Why the speed is capped, in words.
 *
 * @param cap - 0 to 1
 * @param loopMs - measured round trip to the gateway
 * @param pictureMs - age of the picture; negative: none
 * @param rule - the interlock that slows driving down now; empty: none does
 */
export function capWords(cap: number, loopMs: number, pictureMs: number, rule = ""): string {
  if (cap >= 0.995) return "";
  const share = cap <= 0 ? msg("No driving") : msg(str`Speed capped to ${(cap * 100).toFixed(0)}\u202f%`);
  if (rule !== "") return `${share}: ${rule}.`;
  if (loopMs > 150) return msg(str`${share}: the link is slow.`);
  if (pictureMs < 0) return msg(str`${share}: there is no picture.`);
  if (pictureMs > 500) return msg(str`${share}: the picture is old.`);
  return msg(str`${share} by the gateway.`);
}
