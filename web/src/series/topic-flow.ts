/** How a raw topic comes: how often, how old its newest message is, and when that is too old. Pure. */

/** Silence of a topic that comes often counts from here on (ms); of one whose rate is not known yet. */
const LEAST_STALE_MS = 5000;
const UNKNOWN_STALE_MS = 10_000;
const PERIODS = 3;

interface Arrival {
  readonly seq: number;
  readonly timeUs: number;
}

export class TopicFlow {
  private first: Arrival | null = null;
  private last: Arrival | null = null;
  private bornMs: number | null = null;

  /** @param nowMs a clock that goes steadily; `ageMs` is how old the message was when it came */
  count({ seq, timeUs, ageMs }: Arrival & { readonly ageMs: number }, nowMs: number): void {
    const arrival = { seq, timeUs };
    // A gateway that begins anew counts anew; and what was long ago says nothing of now.
    if (this.last === null || this.first === null || seq <= this.last.seq) this.first = arrival;
    else if (seq - this.first.seq > 200) this.first = this.last;
    this.last = arrival;
    this.bornMs = nowMs - ageMs;
  }

  /** How often it comes (Hz); null before two messages came. */
  get hertz(): number | null {
    const { first, last } = this;
    if (first === null || last === null || last.timeUs <= first.timeUs) return null;
    return ((last.seq - first.seq) * 1e6) / (last.timeUs - first.timeUs);
  }

  /** How old the newest message is (ms); null before one came. */
  ageMs(nowMs: number): number | null {
    return this.bornMs === null ? null : Math.max(0, nowMs - this.bornMs);
  }

  /** Whether the newest message is older than a topic's that comes like this one. */
  isStale(nowMs: number): boolean {
    const age = this.ageMs(nowMs);
    if (age === null) return false;
    const { hertz } = this;
    return age > (hertz === null ? UNKNOWN_STALE_MS : Math.max(LEAST_STALE_MS, (PERIODS * 1000) / hertz));
  }
}
