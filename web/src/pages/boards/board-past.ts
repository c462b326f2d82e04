/** A board's page looks back: it owns the past moment, moves it with the pictures that are drawn, and shows its bar. */

import { html, nothing, type ReactiveController, type ReactiveControllerHost } from "lit";
import type { BoardQuery } from "../../boards/board-query.js";
import { PAST_SPEEDS, PastBoard } from "../../state/past/past-board.js";
import type { PastSource } from "../../state/past/past-chunks.js";
import "../../elements/board/time-bar.js";
import "../../elements/feedback/banner.js";

/** Who looks back begins so much before now (µs). */
const BACK_US = 60e6;

export class BoardPast implements ReactiveController {
  board: PastBoard | null = null;
  private frame = 0;
  private stop: (() => void) | null = null;
  /** The moment as the address last said it, and as it was written there (µs). */
  private followed: number | null = null;
  private written: number | null = null;

  /** @param write puts a moment into the address; null for now */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly source: () => PastSource,
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
      .speeds=${PAST_SPEEDS}
      .state=${board.state}
      ?playing=${board.playing}
      ?at-end=${board.isAtEnd}
      @t-play=${this.onPlay}
      @t-seek=${this.onSeek}
      @t-step=${this.onStep}
      @t-speed=${this.onSpeed}
      @t-now=${this.onNow}
      @t-retry=${this.onRetry}
    ></t-time-bar>`;
  }

  private open(site: string, us: number): void {
    this.close();
    this.board = new PastBoard(site, this.source(), us);
    this.written = us;
    this.stop = this.board.subscribe(() => {
      this.host.requestUpdate();
    });
    this.frame = requestAnimationFrame(this.onFrame);
  }

  private close(): void {
    cancelAnimationFrame(this.frame);
    this.stop?.();
    this.stop = null;
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

  private readonly onNow = (): void => {
    this.write(null);
  };

  private readonly onRetry = (): void => {
    this.board?.retry();
  };
}
