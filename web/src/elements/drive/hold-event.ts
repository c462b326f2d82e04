/** How an element says that the driver holds something. */

/** -1 to 1; see `controllers/drive/stick`. */
export interface HoldStick {
  readonly forward: number;
  readonly turn: number;
  readonly side?: number;
  readonly joints?: readonly number[];
}

export type HoldAct = "press" | "move" | "release" | "cancel";

export interface HoldDetail {
  readonly act: HoldAct;
  /** Names what is held, so that the same can be let go. */
  readonly source: string;
  readonly stick: HoldStick;
  readonly kind: "digital" | "analog";
}

export function holdEvent(hold: HoldDetail): CustomEvent<HoldDetail> {
  return new CustomEvent("t-hold", { detail: hold, bubbles: true, composed: true });
}

declare global {
  interface GlobalEventHandlersEventMap {
    "t-hold": CustomEvent<HoldDetail>;
  }
}
