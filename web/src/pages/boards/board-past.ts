/** A board's page looks back: it owns the past moment, moves it with the pictures that are drawn, and shows its bar. */

import { html, nothing, type ReactiveController, type ReactiveControllerHost } from "lit";
import { repeat } from "lit/directives/repeat.js";
import type { BoardQuery } from "../../boards/board-query.js";
import { barSpan } from "../../elements/board/time-bar.js";
import { formatClock } from "../../format/time.js";
import { HOUR_US } from "../../series/zone-clock.js";
import { PAST_SPEEDS, PastBoard } from "../../state/past/past-board.js";
import type { PastSource } from "../../state/past/past-chunks.js";
import { clusterMarks, eventMarks, type MarkCluster } from "../history/chart/event-marks.js";
import { renderMarkShape } from "../history/chart/mark-shapes.js";
import { EventsLoader, type EventsSource } from "../history/data/events-loader.js";
import "../../elements/feedback/banner.js";

/** Who looks back begins so much before now (µs). */
const BACK_US = 60e6;

/** Marks nearer than this part of the bar are one: each is as wide as a finger needs, on a phone, too. */
const APART = 0.07;
const NO_NAMES: ReadonlyMap<string, string> = new Map();

export class BoardPast implements ReactiveController {
  board: PastBoard | null = null;
  private lengthUs = HOUR_US;
  private happened: EventsLoader | null = null;
  private frame = 0;
  private stop: (() => void) | null = null;
  /** The moment as the address last said it, and as it was written there (µs). */
  private followed: number | null = null;
  private written: number | null = null;

  /** @param write puts a moment into the address; null for now */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly source: () => PastSource & EventsSource,
    private readonly write: (us: number | null) => void,
  ) {
    host.addController(this);
  }

  hostConnected(): void {
    this.host.requestUpdate();
  }

  hostDisconnected(): void {
    this.close();
  }

  /** The address says which moment; call it from `willUpdate`. An empty site has no past. */
  follow(site: string, { at }: BoardQuery): void {
    const { board } = this;
    if (at === null || site === "") this.close();
    else if (board?.site !== site) this.open(site, at);
    else if (at !== this.followed && at !== this.written) board.seek(at);
    this.followed = at;
  }

  readonly lookBack = (): void => {
    this.write(Date.now() * 1000 - BACK_US);
  };

  renderBar(zone: string, { wrongAt }: BoardQuery): unknown {
    const { board } = this;
    if (wrongAt !== "") {
      return html`<t-banner kind="bad">The address asks for the moment “${wrongAt}”, which is no time. Expected is one such as at=2026-03-29T21:15:00Z. The board shows now.</t-banner>`;
    }
    if (board === null) return nothing;
    return html`<t-time-bar
      .us=${board.us}
      .end=${board.endUs}
      .zone=${zone}
      .speed=${board.speed}
      .length=${this.lengthUs}
      .speeds=${PAST_SPEEDS}
      .state=${board.state}
      ?playing=${board.playing}
      ?at-end=${board.isAtEnd}
      @t-play=${this.onPlay}
      @t-seek=${this.onSeek}
      @t-step=${this.onStep}
      @t-length=${this.onLength}
      @t-speed=${this.onSpeed}
      @t-now=${this.onNow}
      @t-retry=${this.onRetry}
      >${this.renderMarks(board, zone)}</t-time-bar
    >`;
  }

  /** Alarms, commands, sightings, recordings: what the logbook has, as far as it is open to the person. */
  private renderMarks(board: PastBoard, zone: string): unknown {
    const { happened } = this;
    const span = barSpan(board.us, board.endUs, this.lengthUs);
    if (happened === null) return nothing;
    // While the slider is moved about, the bar stays with what it has.
    if (board.isSettled || board.playing) happened.loadEvents(board.site, span);
    const clusters = clusterMarks(eventMarks(happened.list.events, NO_NAMES), span, APART);
    return repeat(clusters, ({ timeUs }) => timeUs, (cluster) => this.renderMark(cluster, (cluster.timeUs - span.fromUs) / this.lengthUs, zone));
  }

  private renderMark({ marks, kind, good }: MarkCluster, share: number, zone: string): unknown {
    const [first] = marks;
    const more = marks.length > 1 ? `, and ${String(marks.length - 1)} more` : "";
    const words = first === undefined ? "" : `${formatClock(first.timeUs, zone)} ${first.title}: ${first.message}${more}`;
    const seek = (): void => {
      if (first !== undefined) this.board?.seek(first.timeUs);
    };
    return html`<button slot="marks" class=${good ? "mark" : "mark bad"} .style=${`--at: ${share.toFixed(4)}`} type="button" title=${words} aria-label=${words} @click=${seek}>
      <svg viewBox="0 0 16 16" width="12" height="12" aria-hidden="true">${renderMarkShape(kind)}</svg>
    </button>`;
  }

  private open(site: string, us: number): void {
    this.close();
    this.board = new PastBoard(site, this.source(), us);
    this.written = us;
    this.happened = new EventsLoader(this.source(), () => {
      this.host.requestUpdate();
    });
    this.stop = this.board.subscribe(() => {
      this.host.requestUpdate();
    });
    this.frame = requestAnimationFrame(this.onFrame);
  }

  private close(): void {
    cancelAnimationFrame(this.frame);
    this.stop?.();
    this.stop = null;
    this.happened?.close();
    this.happened = null;
    this.board?.close();
    this.board = null;
  }

  private readonly onFrame = (): void => {
    const { board } = this;
    if (board === null) return;
    board.tick();
    // As the address has it: to the millisecond.
    const us = Math.floor(board.us / 1000) * 1000;
    if (!board.playing && board.isSettled && us !== this.written) {
      this.written = us;
      this.write(us);
    }
    this.frame = requestAnimationFrame(this.onFrame);
  };

  private readonly onPlay = (): void => {
    if (this.board?.playing === true) this.board.pause();
    else this.board?.play();
  };

  private readonly onSeek = (event: CustomEvent<number>): void => {
    this.board?.seek(event.detail);
  };

  private readonly onStep = (event: CustomEvent<number>): void => {
    this.board?.step(event.detail);
  };

  private readonly onSpeed = (event: CustomEvent<number>): void => {
    this.board?.setSpeed(event.detail);
  };

  private readonly onLength = (event: CustomEvent<number>): void => {
    this.lengthUs = event.detail;
    this.host.requestUpdate();
  };

  private readonly onNow = (): void => {
    this.write(null);
  };

  private readonly onRetry = (): void => {
    this.board?.retry();
  };
}
