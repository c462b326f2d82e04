/** The rows of an endless list, the newest first: asked for page by page, what is new put above. */

/** What is new is in the hub's list this soon after it was told (ms). */
const SOON_MS = 600;

export interface IdentifiedRow {
  readonly id: string;
}

export interface RowsPage<R> {
  readonly rows: readonly R[];
  /** There are older ones. */
  readonly more: boolean;
}

export class InfiniteRows<R extends IdentifiedRow> {
  private held: readonly R[] = [];
  private left = true;
  private asking = false;
  private wrong: unknown = null;
  private question: string | null = null;
  /** Counts beginnings: what was asked for before one is dropped. */
  private run = 0;
  private looking = false;
  private told = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private late = false;

  /**
   * @param find gives the page behind the row of that id, or the newest one for an empty text
   * @param changed is called when there is something to draw
   * @param fits tells whether a row is still to be shown, once newer ones have come
   */
  constructor(
    private readonly find: (before: string) => Promise<RowsPage<R>>,
    private readonly changed: () => void,
    private readonly fits: (row: R) => boolean = () => true,
  ) {}

  get rows(): readonly R[] {
    return this.held;
  }

  /** There are older ones than those that are shown. */
  get hasMore(): boolean {
    return this.left;
  }

  /** Older ones are on their way. */
  get loading(): boolean {
    return this.asking;
  }

  /** Why older ones did not come; null when they did. */
  get renderFailure(): unknown {
    return this.wrong;
  }

  /** Whether something has been asked for. */
  get hasStarted(): boolean {
    return this.question !== null;
  }

  /** Begins anew when the question is another than the last; call it from `willUpdate`. */
  load(question: string): void {
    if (question === this.question) return;
    this.question = question;
    this.setRows([], true);
    void this.loadOlder();
  }

  async loadOlder(): Promise<void> {
    if (!this.hasStarted || this.asking || !this.left || this.wrong !== null) return;
    const { run } = this;
    this.asking = true;
    this.changed();
    try {
      const found = await this.find(this.held.at(-1)?.id ?? "");
      if (run !== this.run) return;
      this.held = mergedRows(found.rows, this.held, false) ?? this.held;
      this.left = found.more;
    } catch (error) {
      if (run === this.run) this.wrong = error;
    } finally {
      if (run === this.run) {
        this.asking = false;
        this.changed();
      }
    }
  }

  /** After a failure. */
  readonly retry = (): void => {
    this.wrong = null;
    this.changed();
    void this.loadOlder();
  };

  /** Looks for newer ones soon; what comes one after the other is looked for together. */
  scheduleRefresh(): void {
    if (this.timer === undefined) this.timer = setTimeout(this.refresh, SOON_MS);
    else this.late = true;
  }

  /** Puts what is new above the rest. */
  async loadNewer(): Promise<void> {
    this.told += 1;
    if (!this.hasStarted || this.looking) return;
    this.looking = true;
    let { run } = this;
    let told = 0;
    // What was told meanwhile may be missing from the answer.
    while (run === this.run && told !== this.told) {
      told = this.told;
      try {
        const found = await this.find("");
        if (run === this.run) run = this.mergeNewest(found);
      } catch {
        // The next news, or the next page, tries again.
      }
    }
    if (run === this.run) this.looking = false;
  }

  /** Changes rows that are shown. */
  updateRows(how: (rows: readonly R[]) => readonly R[]): void {
    this.held = how(this.held);
    this.changed();
  }

  /** Looks for nothing any more. */
  stopPolling(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.late = false;
  }

  private readonly refresh = (): void => {
    this.timer = this.late ? setTimeout(this.refresh, SOON_MS) : undefined;
    this.late = false;
    void this.loadNewer();
  };

  private setRows(rows: readonly R[], more: boolean): void {
    this.run += 1;
    this.held = rows;
    this.left = more;
    this.asking = false;
    this.looking = false;
    this.wrong = null;
  }

  /** Gives the run that goes on: another where more than a page is new, and all begins with that. */
  private mergeNewest(found: RowsPage<R>): number {
    const rows = this.held.length === 0 ? null : mergedRows(this.held, found.rows, found.more);
    if (rows === null) this.setRows(found.rows, found.more);
    else this.held = rows;
    this.held = this.held.filter(this.fits);
    this.looking = true;
    this.changed();
    return this.run;
  }
}

/** The newest page put before the rows that are shown; null when there is a hole between them. */
export function mergedRows<R extends IdentifiedRow>(rows: readonly R[], newest: readonly R[], more: boolean): readonly R[] | null {
  const ids = new Set(newest.map(({ id }) => id));
  if (more && rows.length > 0 && !rows.some(({ id }) => ids.has(id))) return null;
  return [...newest, ...rows.filter(({ id }) => !ids.has(id))];
}
