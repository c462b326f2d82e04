/** The hub's monotonic clock, told by this page's own. */

interface ClockExchange {
  readonly roundTripMs: number;
  readonly offsetMs: number;
}

/** Exchanges kept; one comes each second, so a drifting clock is followed within this many. */
const KEPT = 30;

/**
 * Learns the offset between two clocks from pings. The exchange with the shortest round trip is
 * believed: its error is at most half of that.
 */
export class HubClock {
  private exchanges: ClockExchange[] = [];

  /**
   * @param sentMs this page's monotonic clock when the ping left
   * @param nowMs the same clock when the answer came
   * @param hubUs the hub's monotonic clock in between
   */
  recordExchange(sentMs: number, nowMs: number, hubUs: number): void {
    const roundTripMs = nowMs - sentMs;
    if (!(roundTripMs >= 0)) return;
    const offsetMs = hubUs / 1000 - (sentMs + roundTripMs / 2);
    this.exchanges.push({ roundTripMs, offsetMs });
    if (this.exchanges.length > KEPT) this.exchanges.shift();
  }

  /** Forgets all: the next connection may be to a restarted hub. */
  reset(): void {
    this.exchanges = [];
  }

  /** Newest round trip (ms); NaN before the first. */
  get roundTripMs(): number {
    return this.exchanges.at(-1)?.roundTripMs ?? Number.NaN;
  }

  /** Age (ms) of a moment on the hub's monotonic clock; NaN before the first exchange. */
  ageMs(hubUs: number, nowMs: number): number {
    let best: ClockExchange | undefined;
    for (const exchange of this.exchanges) {
      if (best === undefined || exchange.roundTripMs < best.roundTripMs) best = exchange;
    }
    return best === undefined ? Number.NaN : nowMs + best.offsetMs - hubUs / 1000;
  }
}
