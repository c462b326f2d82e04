/** A connection that is not there: keeps what is sent, says what the test wants said. */

import type { FromBrowser, ToBrowser } from "../../../src/generated/wire.js";
import type { DriveConnection } from "../../../src/controllers/drive/drive-session.js";
import type { LinkState } from "../../../src/wire/connection.js";

type Sent = { readonly t: FromBrowser["t"] } & Readonly<Record<string, unknown>>;

export class FakeLine implements DriveConnection {
  state: LinkState = "open";
  bufferedBytes = 0;
  readonly sent: Sent[] = [];
  private readonly listeners = new Map<string, Set<(message: never) => void>>();
  private readonly states = new Set<(state: LinkState) => void>();

  readonly send: DriveConnection["send"] = (message) => {
    if (this.state !== "open") return false;
    this.sent.push({ ...message });
    return true;
  };

  readonly onMessage: DriveConnection["onMessage"] = (tag, listener) => {
    const set = this.listeners.get(tag) ?? new Set();
    this.listeners.set(tag, set);
    set.add(listener);
    return () => set.delete(listener);
  };

  readonly onState: DriveConnection["onState"] = (listener) => {
    this.states.add(listener);
    return () => this.states.delete(listener);
  };

  say(message: ToBrowser): void {
    for (const listener of this.listeners.get(message.t) ?? []) listener(message as never);
  }

  become(state: LinkState): void {
    this.state = state;
    for (const listener of this.states) listener(state);
  }

  /** What was sent of a kind since the last call, whatever else was sent. */
  take(tag: FromBrowser["t"]): Sent[] {
    const found = this.sent.filter((message) => message.t === tag);
    this.sent.length = 0;
    return found;
  }

  get listening(): number {
    return [...this.listeners.values()].reduce((sum, set) => sum + set.size, this.states.size);
  }
}
