/** What to tell a person when asking the hub for something failed. */

import { msg, str } from "@lit/localize";
import { formatDuration } from "./duration.js";

export interface Advice {
  readonly what: string;
  readonly how: string;
}

/** The part of a refusal that this needs; see `wire/http.ts`. */
interface HubRefusal {
  readonly status: number;
  readonly code: string;
  readonly retryAfter: number;
  readonly message: string;
}

const UNREACHABLE: Advice = {
  what: msg("The hub cannot be reached."),
  how: msg("Check the network between this device and the hub, and that the hub is running. It is safe to try again."),
};

/** @param asked what was asked for, as the object of a sentence: `the list of sites` */
export function adviceFor(error: unknown, asked: string): Advice {
  if (!isRefusal(error)) return UNREACHABLE;
  if (error.status === 403) {
    return { what: msg(str`You may not see ${asked}.`), how: msg("An admin of this hub can give you the right.") };
  }
  if (error.status === 404) {
    return { what: msg(str`There is no such thing here: ${asked}.`), how: msg("It may have been renamed or removed.") };
  }
  return { what: msg(str`The hub could not give ${asked}.`), how: error.message };
}

/** @param asked what was to be done, as the object of a sentence: `change the password` */
export function actionAdvice(error: unknown, asked: string): Advice {
  if (!isRefusal(error)) return UNREACHABLE;
  const what = msg(str`The hub did not ${asked}.`);
  if (error.status === 429) return { what, how: msg(str`Too many tries. Try again ${waitText(error.retryAfter)}.`) };
  return { what, how: asSentence(error.message) };
}

/** How long to wait, where the hub said it (s). */
export function waitText(seconds: number): string {
  return seconds > 0 ? msg(str`in ${formatDuration(Math.ceil(seconds))}`) : msg("in a little while");
}

/** The hub's words for programs begin small and end without a point. */
function asSentence(text: string): string {
  const first = text.charAt(0).toUpperCase() + text.slice(1);
  return first === "" || /[.!?]$/.test(first) ? first : `${first}.`;
}

/** Advice for a sign-in that failed. */
export function signInAdvice(error: unknown): Advice {
  if (!isRefusal(error)) return UNREACHABLE;
  if (error.status === 429) {
    return { what: msg("Too many tries."), how: msg(str`The hub delays repeated tries. Try again ${waitText(error.retryAfter)}.`) };
  }
  if (error.code === "provider") return { what: msg("The provider could not be asked."), how: asSentence(error.message) };
  if (isPasskey(error)) return { what: msg("You were not signed in by a passkey."), how: asSentence(error.message) };
  if (error.code === "factor_locked") {
    return { what: msg("Codes are not taken now."), how: msg("Too many were wrong. Use a recovery code or a passkey, or wait an hour.") };
  }
  if (isFactor(error)) {
    return { what: msg("This code is wrong."), how: msg(str`${asSentence(error.message)} Each code works once; wait for the next one.`) };
  }
  if (error.status === 401 || error.status === 403) {
    return { what: msg("Name or password is wrong."), how: msg("Check both; capital letters count.") };
  }
  return { what: msg("The hub did not let you in."), how: error.message };
}

/** The password is right, and the hub wants the second factor besides. */
export function isFactor(error: unknown): boolean {
  return isRefusal(error) && error.status === 401 && (error.code === "factor" || error.code === "factor_locked");
}

/** A passkey did not answer, cannot be used here, or there is none. */
export function isPasskey(error: unknown): boolean {
  return isRefusal(error) && ["passkey", "no_passkey", "no_name", "provider"].includes(error.code);
}

/** Seconds that the hub wants to be left alone; 0 when it did not say so. */
export function waitOf(error: unknown): number {
  return isRefusal(error) && error.status === 429 ? error.retryAfter : 0;
}

/** The hub says that this person may not. */
export function isForbidden(error: unknown): boolean {
  return isRefusal(error) && error.status === 403;
}

function isRefusal(error: unknown): error is HubRefusal {
  return error instanceof Error && "status" in error && "retryAfter" in error;
}
