/** Which key means what while driving. Pure: an event's fields go in, a meaning comes out. */

import type { Direction } from "./stick.js";

export type KeyMeaning =
  | { readonly kind: "push"; readonly direction: Direction }
  | { readonly kind: "halt" }
  | { readonly kind: "faster" }
  | { readonly kind: "slower" }
  | { readonly kind: "STOP" };

/** The fields of a `KeyboardEvent` that decide. */
export interface KeyPress {
  readonly code: string;
  readonly key: string;
  readonly repeat: boolean;
  readonly ctrlKey: boolean;
  readonly altKey: boolean;
  readonly metaKey: boolean;
  readonly isComposing: boolean;
}

// Letters go by `key`, so that w a s d x are the letters printed on the person's own keyboard.
const LETTERS: Readonly<Record<string, KeyMeaning>> = {
  w: { kind: "push", direction: "forward" },
  x: { kind: "push", direction: "backward" },
  a: { kind: "push", direction: "left" },
  d: { kind: "push", direction: "right" },
  q: { kind: "push", direction: "sideLeft" },
  e: { kind: "push", direction: "sideRight" },
  s: { kind: "halt" },
  "+": { kind: "faster" },
  "=": { kind: "faster" },
  "-": { kind: "slower" },
};

const CODES: Readonly<Record<string, KeyMeaning>> = {
  ArrowUp: { kind: "push", direction: "forward" },
  ArrowDown: { kind: "push", direction: "backward" },
  ArrowLeft: { kind: "push", direction: "left" },
  ArrowRight: { kind: "push", direction: "right" },
  NumpadAdd: { kind: "faster" },
  NumpadSubtract: { kind: "slower" },
  Escape: { kind: "STOP" },
};

/** What pressing this key asks for; null when it is not ours. */
export function meaningOf(press: KeyPress): KeyMeaning | null {
  if (press.repeat || press.isComposing) return null;
  if (press.ctrlKey || press.altKey || press.metaKey) return null;
  return CODES[press.code] ?? LETTERS[press.key.toLowerCase()] ?? null;
}

/** Names a held key. By its place: letting go of Shift first changes `key`, never `code`. */
export function sourceOf(press: Pick<KeyPress, "code">): string {
  return `key:${press.code}`;
}

/** What decides of an element on the way of a key event. */
export interface KeyTaker {
  readonly tagName?: string;
  /** Of an input. */
  readonly type?: string;
  readonly isContentEditable?: boolean;
  readonly dataset?: Readonly<Record<string, string | undefined>>;
}

const WITHOUT_TEXT: ReadonlySet<string> = new Set([
  "checkbox", "radio", "button", "submit", "reset", "range", "color",
]);

/**
 * Whether an element on the way uses this key itself: a field being typed in, a slider with the
 * arrow keys, a map (`data-keys="own"`).
 */
export function usesKeys(path: readonly KeyTaker[], code: string): boolean {
  const arrow = code.startsWith("Arrow");
  return path.some((taker) => {
    if (taker.isContentEditable === true) return true;
    if (taker.dataset?.["keys"] === "own" && arrow) return true;
    if (taker.tagName === "TEXTAREA" || taker.tagName === "SELECT") return true;
    return taker.tagName === "INPUT" && (arrow || !WITHOUT_TEXT.has(taker.type ?? "text"));
  });
}
