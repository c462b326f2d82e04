/** What happened in a window, asked again when the window leaves what is known or time has gone on. */

import type { EventList } from "../../../generated/api.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import { SECOND_US } from "../../../series/zone-clock.js";
import { LatestRequest } from "./latest-request.js";

export interface EventsSource {
  events(site: string, span: TimeSpan, limit: number, signal?: AbortSignal): Promise<EventList>;
}

interface EventsQuestion {
  readonly site: string;
  readonly span: TimeSpan;
}

const LIMIT = 1000;
/** A window that follows is asked for again when this much time has come in (µs). */
const EVERY_US = 5 * SECOND_US;
const NOTHING_YET: EventList = { events: [], more: false };

export class EventsLoader {
  list: EventList = NOTHING_YET;
  private readonly asker: LatestRequest<EventsQuestion, EventList>;

  constructor(happened: EventsSource, changed: () => void) {
    this.asker = new LatestRequest<EventsQuestion, EventList>({
      fetch: ({ site, span }, signal) => happened.events(site, span, LIMIT, signal),
      isStillUseful: (running, next) => running.site === next.site,
      onAnswer: (list) => {
        this.list = list;
      },
      onChange: changed,
    });
  }

  get failed(): boolean {
    return this.asker.state === "failed";
  }

  /** Asks for some more than the window, in steps, so that a small move asks for nothing new. */
  loadEvents(site: string, span: TimeSpan): void {
    const step = Math.max(EVERY_US, 2 ** Math.floor(Math.log2(lengthOf(span) / 4)));
    const fromUs = Math.max(0, Math.floor(span.fromUs / step) * step);
    this.asker.request({ site, span: { fromUs, toUs: Math.ceil(span.toUs / step) * step } });
  }

  close(): void {
    this.asker.cancelRequest();
    this.list = NOTHING_YET;
  }
}
