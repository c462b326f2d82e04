/** Everything to drive with, tied to the seat: lease, pad, arrows, speed and what comes of it. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { capWords } from "../../controllers/drive/drive-messages.js";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import { padStick } from "../../controllers/drive/stick.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import "../../elements/drive/arrow-pad.js";
import "../../elements/drive/drive-readout.js";
import type { Motion } from "../../elements/drive/drive-readout.js";
import "../../elements/drive/lease-line.js";
import "../../elements/drive/touch-pad.js";
import "../../elements/drive/speed-limit.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { formatMs } from "../../format/duration.js";
import { lockText } from "../../format/interlock-reason.js";
import type { HoldDetail } from "../../elements/drive/hold-event.js";
import { interlocksContext } from "../../state/contexts.js";
import type { DeviceShape, SignalShape } from "../../generated/api.js";

const DRAW_EVERY_MS = 200;

@customElement("t-drive-pad")
export class DrivePad extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-2);
      }
      .hands {
        display: grid;
        grid-template-columns: minmax(6.5rem, var(--t-pad-size, 1.25fr)) minmax(8.75rem, var(--t-arrows-size, 1fr));
        align-items: center;
        justify-content: space-evenly;
        gap: var(--t-space-4);
      }
      /* Below the pad: a word that comes or goes must not move what the thumb lies on. */
      .trouble {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .trouble:empty {
        display: none;
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        justify-content: space-between;
        gap: 0 var(--t-space-4);
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
      .hint {
        ${quietText}
      }
      summary {
        cursor: pointer;
        inline-size: fit-content;
        min-block-size: 1.5rem;
      }
      @media (pointer: coarse) {
        .hint {
          display: none;
        }
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) seat: DriveSession | null = null;
  @property({ type: Boolean }) stopped = false;
  /** What is driven is no robot: what locks that one's driving locks nothing here. */
  @property({ type: Boolean }) rehearsing = false;
  /** Age of the picture (ms); negative: none. */
  @property({ attribute: false }) pictureAge: () => number = () => -1;

  private readonly interlocks = new ContextStoreController(this, interlocksContext, () => {
    this.followLock();
  });
  private readonly live = new LiveValuesController(this);
  private stop: (() => void) | null = null;
  private watched: DriveSession | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      this.requestUpdate();
    }, DRAW_EVERY_MS);
    this.observeSignals();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.stop?.();
    this.stop = null;
    this.watched = null;
  }

  override willUpdate(): void {
    this.observeSignals();
    this.followLock();
    const channels = [this.signalWithUnit("m/s"), this.signalWithUnit("rad/s")].flatMap((signal) => signal?.channels ?? []);
    this.live.observeChannels(this.site, channels);
  }

  override render(): TemplateResult | typeof nothing {
    const { seat } = this;
    const limits = this.device?.drive;
    if (!seat || !limits) return nothing;
    const { machine, lease, told } = seat;
    const state = lease.state;
    const idle = !machine.mayDrive;
    return html`
      <t-lease
        .kind=${state.kind}
        .holder=${state.kind === "other" || state.kind === "waiting" ? state.holder : ""}
        .rival=${state.kind === "mine" ? (state.rival?.who ?? "") : ""}
        .answer=${seat.answerRemainingMs}
        .forceable=${state.kind === "other" && state.forceable && (this.device?.rights.includes("admin") ?? false)}
        .remains=${seat.remainingMs}
        .online=${seat.online}
        .stopped=${this.stopped}
        @t-take=${this.takeControl}
        @t-free=${this.releaseControl}
        @t-answer=${this.answerRequest}
        @t-force=${this.forceTakeover}
      ></t-lease>
      <div class="hands" @t-hold=${this.onHold} @t-halt=${this.onHalt}>
        <t-pad ?disabled=${idle} .stickOf=${padStick}></t-pad>
        <t-arrows ?disabled=${idle}></t-arrows>
      </div>
      <p class="trouble" role="alert">${this.lockReason || seat.problem}</p>
      <t-speed-limit
        .level=${machine.speedLevel}
        .speed=${limits.max_speed}
        .turn=${limits.max_turn}
        .shownSpeed=${limits.shown_speed}
        .shownTurn=${limits.shown_turn}
        @t-level=${this.onSpeedLevel}
      ></t-speed-limit>
      <t-drive-readout
        .asked=${machine.requestedVelocity}
        .told=${told ?? NO_MOTION}
        .sent=${told?.sent ?? ""}
        .measured=${this.measuredMotion()}
        .shownSpeed=${limits.shown_speed}
        .shownTurn=${limits.shown_turn}
        .cap=${this.speedCapReason()}
        .refusal=${state.kind === "mine" && !this.stopped ? (told?.why ?? "") : ""}
      ></t-drive-readout>
      <div class="foot">
      <details class="hint">
        <summary>Keys and gamepad</summary>
        <p>
          Hold W&nbsp;A&nbsp;D&nbsp;X or the arrow keys to drive, several at once for a curve; let go to halt. S halts, +
          and − change the speed, Escape is STOP. Gamepad: hold a shoulder button and push the left stick.
        </p>
      </details>
      <span class="loop" title="From this page to the gateway and back, measured while you have control"
        >Round trip ${formatMs(told && told.loop_ms > 0 ? told.loop_ms : Number.NaN)}</span
      >
      </div>
    `;
  }

  /** Why an interlock refuses driving now; empty when none does. */
  private get lockReason(): string {
    if (this.rehearsing) return "";
    const lock = this.device && this.interlocks.store?.lockOf(this.site, this.device.id, "drive");
    return lock ? lockText(lock) : "";
  }

  /** No press counts while driving is locked, and what is held is let go in the same turn. */
  private followLock(): void {
    const { seat } = this;
    if (!seat) return;
    const barred = seat.machine.isBlocked("interlock");
    if (this.lockReason === "" && barred) seat.unblock("interlock");
    else if (this.lockReason !== "" && !barred) seat.block("interlock");
  }

  private speedCapReason(): string {
    const { seat } = this;
    if (!seat?.told || seat.lease.state.kind !== "mine") return "";
    const slow = this.device && this.interlocks.store?.slowOf(this.site, this.device.id);
    return capWords(seat.told.cap, seat.told.loop_ms, this.pictureAge(), slow?.name);
  }

  private measuredMotion(): Motion {
    return { linear: this.freshValue("m/s"), angular: this.freshValue("rad/s") };
  }

  /** The device's first signal in this unit; a stale one counts as none. */
  private freshValue(unit: string): number {
    const signal = this.signalWithUnit(unit);
    const channel = signal?.channels[0];
    if (!signal || channel === undefined) return Number.NaN;
    const fresh = this.live.freshnessOf(channel, signal.max_age) === "live";
    return fresh ? (this.live.readingOf(channel)?.value ?? Number.NaN) : Number.NaN;
  }

  private signalWithUnit(unit: string): SignalShape | undefined {
    return this.device?.signals.find((signal) => signal.type === "number" && signal.unit === unit);
  }

  private observeSignals(): void {
    if (this.watched === this.seat) return;
    this.stop?.();
    this.watched = this.seat;
    this.stop =
      this.seat?.subscribe(() => {
        this.requestUpdate();
      }) ?? null;
  }

  private readonly onHold = (event: CustomEvent<HoldDetail>): void => {
    const { act, source, stick, kind } = event.detail;
    switch (act) {
      case "press":
        this.seat?.pressHold(source, stick, kind);
        return;
      case "move":
        this.seat?.moveHold(source, stick);
        return;
      case "release":
        this.seat?.releaseHold(source);
        return;
      case "cancel":
        this.seat?.cancelHold(source);
        return;
    }
  };

  private readonly onHalt = (): void => {
    this.seat?.haltMotion("stop key");
  };

  private readonly onSpeedLevel = (event: CustomEvent<number>): void => {
    this.seat?.setLevel(event.detail);
  };

  private readonly takeControl = (): void => {
    this.seat?.takeControl();
  };

  private readonly releaseControl = (): void => {
    this.seat?.releaseControl();
  };

  private readonly answerRequest = (event: CustomEvent<boolean>): void => {
    this.seat?.answerRequest(event.detail);
  };

  private readonly forceTakeover = (): void => {
    this.seat?.forceTakeover();
  };
}

const NO_MOTION: Motion = { linear: Number.NaN, angular: Number.NaN };

declare global {
  interface HTMLElementTagNameMap {
    "t-drive-pad": DrivePad;
  }
}
