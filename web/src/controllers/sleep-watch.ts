/** Notices that the device slept: timers stood still, and with some systems the page's own clock, too. */

/** Two looks lie a second apart; so much more (ms) and something stood still. */
const STOOD_STILL_MS = 5000;
/** So much more of the wall's time (ms) than of ours: our clock stood still. */
const CLOCK_STOOD_MS = 2000;

/** What two looks at the clocks say. */
export interface SleepFinding {
  /** Timers did not run: a socket may be dead without anybody having been told. */
  readonly slept: boolean;
  /** So long (ms) did the page's monotonic clock not count; ages measured by it are so much too young. */
  readonly uncountedMs: number;
}

const AWAKE: SleepFinding = { slept: false, uncountedMs: 0 };

export class SleepWatch {
  private seenNow: number;
  private seenWall: number;

  /**
   * @param now - the page's monotonic clock (ms), which some systems stop while they sleep
   * @param wall - the time of day (ms since 1970)
   */
  constructor(
    private readonly now: () => number = () => performance.now(),
    private readonly wall: () => number = () => Date.now(),
  ) {
    this.seenNow = now();
    this.seenWall = wall();
  }

  /** Compares with the look before; call it each second, and when the page is shown. */
  checkClocks(): SleepFinding {
    const [now, wall] = [this.now(), this.wall()];
    const [counted, passed] = [now - this.seenNow, wall - this.seenWall];
    this.seenNow = now;
    this.seenWall = wall;
    // A clock that was set back says nothing of sleep.
    const uncountedMs = passed - counted > CLOCK_STOOD_MS ? passed - counted : 0;
    if (uncountedMs === 0 && counted < STOOD_STILL_MS) return AWAKE;
    return { slept: true, uncountedMs };
  }
}
