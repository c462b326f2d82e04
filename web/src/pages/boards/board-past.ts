/** A board's page looks back: it owns the past moment, moves it with the pictures that are drawn, and shows its bar. */

import { msg, str } from "@lit/localize";
import { html, nothing, type ReactiveController, type ReactiveControllerHost } from "lit";
import { repeat } from "lit/directives/repeat.js";
import type { BoardQuery } from "../../boards/board-query.js";
import { barSpan } from "../../elements/board/time-bar.js";
import { formatClock } from "../../format/time.js";
import type { TimeSpan } from "../../series/time-window.js";
import { HOUR_US } from "../../series/zone-clock.js";
import { PAST_SPEEDS, PastBoard } from "../../state/past/past-board.js";
import type { PastSource } from "../../state/past/past-chunks.js";
import type { SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { RecordedApi } from "../../topics/recorded-api.js";
import { clusterMarks, eventMarks, mergeMarks, type EventMark, type MarkCluster } from "../history/chart/event-marks.js";
import { renderMarkShape } from "../history/chart/mark-shapes.js";
import { EventsLoader, type EventsSource } from "../history/data/events-loader.js";
import { NotesApi } from "../notes/notes-api.js";
import { noteMarks } from "../notes/note-marks.js";
import { NoteWriter } from "../notes/note-writer.js";
import { NotesLoader } from "../notes/notes-loader.js";
import { draftAt } from "../notes/notes-query.js";
import type { ChosenRuns } from "../runs/run-picker.js";
import "../../elements/feedback/banner.js";
import "../../elements/forms/button.js";
import "../runs/compare-runs.js";

/** Who looks back begins so much before now (µs). */
const BACK_US = 60e6;

/** Marks nearer than this part of the bar are one: each is as wide as a finger needs, on a phone, too. */
const APART = 0.07;
/** Two runs that play may be so far apart, at their speed (µs). */
const APART_US = 0.3e6;
const NO_NAMES: ReadonlyMap<string, string> = new Map();

type BoardPastSource = PastSource & EventsSource & Pick<HubApi, "request" | "requestBytes">;

export class BoardPast implements ReactiveController {
  board: PastBoard | null = null;
  /** Another run, which stands beside it and goes with it; null for none. */
  other: PastBoard | null = null;
  /** The board's time less the other run's (µs). */
  private shiftUs = 0;
  private lengthUs = HOUR_US;
  private happened: EventsLoader | null = null;
  private noted: NotesLoader | null = null;
  private readonly writer: NoteWriter;
  /** Where a note over a span is to begin (µs); null while none was begun. */
  private begunUs: number | null = null;
  private frame = 0;
  private stop: (() => void) | null = null;
  private stopOther: (() => void) | null = null;
  /** The moment as the address last said it, and as it was written there (µs). */
  private followed: number | null = null;
  private written: number | null = null;

  /** @param write puts a moment into the address, and that of another run beside it; null for now, and for none */
  constructor(
    private readonly host: ReactiveControllerHost & HTMLElement,
    private readonly source: () => BoardPastSource,
    private readonly write: (us: number | null, against: number | null) => void,
  ) {
    host.addController(this);
    this.writer = new NoteWriter(host, () => this.board?.site ?? "", () => {
      this.noted?.invalidate();
      host.requestUpdate();
    });
  }

  hostConnected(): void {
    this.host.requestUpdate();
  }

  hostDisconnected(): void {
    this.close();
  }

  /** The address says which moment; call it from `willUpdate`. An empty site has no past. */
  follow(site: string, { at, against }: BoardQuery): void {
    const { board } = this;
    if (at === null || site === "") this.close();
    else if (board?.site !== site) this.open(site, at);
    else if (at !== this.followed && at !== this.written) board.seek(at);
    if (at !== null && site !== "") this.followOther(site, at, against);
    this.followed = at;
  }

  /** The other run keeps its distance while both move; another distance is another comparison. */
  private followOther(site: string, at: number, against: number | null): void {
    const shiftUs = against === null ? 0 : at - against;
    if (against === null) this.closeOther();
    else if (this.other?.site !== site || shiftUs !== this.shiftUs) {
      this.closeOther();
      this.shiftUs = shiftUs;
      this.other = new PastBoard(site, this.source(), against, undefined, new RecordedApi(this.source()));
      this.stopOther = this.other.subscribe(() => {
        this.host.requestUpdate();
      });
    }
  }

  private closeOther(): void {
    this.stopOther?.();
    this.stopOther = null;
    this.other?.close();
    this.other = null;
  }

  readonly lookBack = (): void => {
    this.write(Date.now() * 1000 - BACK_US, null);
  };

  renderBar(detail: SiteShape, { wrongAt }: BoardQuery): unknown {
    const { board } = this;
    const { zone } = detail;
    const mayWrite = detail.devices.some(({ rights }) => rights.includes("use"));
    if (wrongAt !== "") {
      return html`<t-banner kind="bad">${msg(str`The address asks for the moment “${wrongAt}”, which is no time. Expected is one such as at=2026-03-29T21:15:00Z. The board shows now.`)}</t-banner>`;
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
      ?notes=${mayWrite}
      .begun=${this.begunUs}
      @t-note=${this.onNote}
      @t-begin=${this.onBegin}
      @t-play=${this.onPlay}
      @t-seek=${this.onSeek}
      @t-step=${this.onStep}
      @t-length=${this.onLength}
      @t-speed=${this.onSpeed}
      @t-now=${this.onNow}
      @t-retry=${this.onRetry}
      >${this.renderMarks(board, zone)}
      <t-compare-runs slot="keys" .site=${detail.site} .zone=${zone} .span=${barSpan(board.us, board.endUs, this.lengthUs)} @t-runs=${this.onRuns}></t-compare-runs>
      ${this.other === null ? nothing : html`<t-button slot="keys" kind="quiet" @click=${this.endComparison}>${msg("End the comparison")}</t-button>`}</t-time-bar
    >${this.writer.renderDialog(detail.site, zone, detail)}`;
  }

  /** Alarms, commands, sightings, recordings, notes: what the logbook has, as far as it is open to the person. */
  private renderMarks(board: PastBoard, zone: string): unknown {
    const { happened, noted } = this;
    const span = barSpan(board.us, board.endUs, this.lengthUs);
    if (happened === null || noted === null) return nothing;
    // While the slider is moved about, the bar stays with what it has.
    if (board.isSettled || board.playing) {
      happened.loadEvents(board.site, span);
      noted.loadNotes(board.site, span);
    }
    const notes = noteMarks(noted.notes, NO_NAMES);
    const clusters = clusterMarks(mergeMarks(eventMarks(happened.list.events, NO_NAMES), notes), span, APART);
    const stretches = notes.map((note) => this.renderStretch(note, span));
    return html`${stretches}${repeat(clusters, ({ timeUs }) => timeUs, (cluster) => this.renderMark(cluster, (cluster.timeUs - span.fromUs) / this.lengthUs, zone))}`;
  }

  /** The part of the bar over which a note lasts; its mark says what it is. */
  private renderStretch({ timeUs, untilUs }: EventMark, { fromUs, toUs }: TimeSpan): unknown {
    if (untilUs === undefined || untilUs < fromUs || timeUs > toUs) return nothing;
    const [from, to] = [Math.max(timeUs, fromUs), Math.min(untilUs, toUs)];
    return html`<span slot="stretches" .style=${`--from: ${((from - fromUs) / this.lengthUs).toFixed(4)}; --part: ${((to - from) / this.lengthUs).toFixed(4)}`}></span>`;
  }

  private renderMark({ marks, kind, good }: MarkCluster, share: number, zone: string): unknown {
    const [first] = marks;
    const more = marks.length > 1 ? msg(str`, and ${String(marks.length - 1)} more`) : "";
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
    this.board = new PastBoard(site, this.source(), us, undefined, new RecordedApi(this.source()));
    this.written = us;
    this.happened = new EventsLoader(this.source(), () => {
      this.host.requestUpdate();
    });
    const find = (of: string, query: string, signal: AbortSignal): ReturnType<NotesApi["findNotes"]> => new NotesApi(this.source(), of).findNotes(query, signal);
    this.noted = new NotesLoader(find, () => {
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
    this.noted?.close();
    this.noted = null;
    this.begunUs = null;
    this.closeOther();
    this.board?.close();
    this.board = null;
  }

  private readonly onFrame = (): void => {
    const { board } = this;
    if (board === null) return;
    board.tick();
    this.moveOther(board);
    // As the address has it: to the millisecond.
    const us = Math.floor(board.us / 1000) * 1000;
    if (!board.playing && board.isSettled && us !== this.written) {
      this.written = us;
      this.write(us, this.other === null ? null : us - this.shiftUs);
    }
    this.frame = requestAnimationFrame(this.onFrame);
  };

  /** At the moment that is shown, or over the span up to it that was begun. */
  private readonly onNote = (event: Event): void => {
    const { board, begunUs } = this;
    if (board === null) return;
    if (board.playing) board.pause();
    const [from, to] = [begunUs ?? board.us, board.us].sort((a, b) => a - b);
    this.begunUs = null;
    this.writer.draft.opener(draftAt(from ?? board.us, to))(event);
  };

  private readonly onBegin = (): void => {
    this.begunUs = this.begunUs === null ? (this.board?.us ?? null) : null;
    this.host.requestUpdate();
  };

  /** One bar moves both: the other run stands, plays and waits as this one does. */
  private moveOther(board: PastBoard): void {
    const { other } = this;
    if (other === null) return;
    if (other.speed !== board.speed) other.setSpeed(board.speed);
    if (board.playing && !other.playing) other.play();
    if (!board.playing && other.playing) other.pause();
    const wanted = board.us - this.shiftUs;
    // While both play each waits for its own values; further apart they are put together again.
    const apart = Math.abs(other.us - wanted) > (board.playing ? APART_US * board.speed : 1);
    if (apart && wanted < other.endUs) other.seek(wanted);
    other.tick();
  }

  /** Which two runs are beside each other from now on: the board of the first, and its distance to the second. */
  private readonly onRuns = ({ detail: { span, shiftUs } }: CustomEvent<ChosenRuns>): void => {
    this.write(span.fromUs, span.fromUs - shiftUs);
  };

  private readonly endComparison = (): void => {
    const { board } = this;
    this.closeOther();
    if (board !== null) this.write(Math.floor(board.us / 1000) * 1000, null);
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
    this.write(null, null);
  };

  private readonly onRetry = (): void => {
    this.board?.retry();
  };
}
