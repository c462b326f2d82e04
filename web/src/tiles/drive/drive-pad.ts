/** Everything to drive with, tied to the seat: lease, pad, arrows, speed and what comes of it. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { padsFound } from "../../controllers/drive/gamepad.js";
import { capWords } from "../../controllers/drive/drive-messages.js";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import { asideStick, padStick, type Stick } from "../../controllers/drive/stick.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import "../../elements/drive/arrow-pad.js";
import "../../elements/drive/drive-readout.js";
import type { Motion } from "../../elements/drive/drive-readout.js";
import "../../elements/drive/touch-pad.js";
import "../../elements/drive/speed-limit.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { formatMs } from "../../format/duration.js";
import { lockText } from "../../format/interlock-reason.js";
import type { HoldDetail } from "../../elements/drive/hold-event.js";
import { readBrowserChoice, saveBrowserChoice } from "../../controllers/browser-choice.js";
import { interlocksContext } from "../../state/contexts.js";
import "../../elements/forms/choice.js";
import type { DeviceShape, SignalShape } from "../../generated/api.js";
import { renderLease } from "./session-lease.js";

const DRAW_EVERY_MS = 200;
const HAND_KEY = "talaia.hand";

/** Which thumb drives on a phone: `both` has pad and arrows, one has the pad at its own side. */
type DrivingHand = "both" | "left" | "right";

const PAD_WAYS = [
  { id: "turn", label: msg("Turn", { id: "turn.verb" }) },
  { id: "move", label: msg("Move", { id: "move.verb" }) },
] as const;

function sidePadStick(right: number, down: number, radius: number): Stick {
  return asideStick(padStick(right, down, radius));
}

const HANDS = [
  { id: "both", label: msg("Both") },
  { id: "left", label: msg("Left") },
  { id: "right", label: msg("Right") },
] as const;

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
      .aside {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        justify-content: space-between;
        gap: var(--t-space-2);
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
      .hand {
        display: none;
      }
      @media (max-width: 52rem) and (orientation: portrait) {
        .hand {
          display: flex;
          flex-wrap: wrap;
          align-items: center;
          justify-content: space-between;
          gap: var(--t-space-2);
        }
        /* One thumb reaches all that is needed while driving; the arrows say the same as the pad. */
        :host([hand="left"]),
        :host([hand="right"]) {
          grid-template-columns: minmax(0, 1fr) 11.5rem;
          grid-template-areas: "lease lease" "speed hands" "aside aside" "trouble trouble" "readout readout" "hand hand" "foot foot";
          align-items: end;
        }
        :host([hand="left"]) {
          grid-template-columns: 11.5rem minmax(0, 1fr);
          grid-template-areas: "lease lease" "hands speed" "aside aside" "trouble trouble" "readout readout" "hand hand" "foot foot";
        }
        :host(:not([hand="both"])) .hands {
          grid-area: hands;
          grid-template-columns: 100%;
        }
        :host(:not([hand="both"])) t-arrows {
          display: none;
        }
        :host(:not([hand="both"])) t-lease {
          grid-area: lease;
        }
        :host(:not([hand="both"])) .aside {
          grid-area: aside;
        }
        :host(:not([hand="both"])) t-speed-limit {
          grid-area: speed;
        }
        :host(:not([hand="both"])) .trouble {
          grid-area: trouble;
        }
        :host(:not([hand="both"])) t-drive-readout {
          grid-area: readout;
        }
        :host(:not([hand="both"])) .hand {
          grid-area: hand;
        }
        :host(:not([hand="both"])) .foot {
          grid-area: foot;
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

  @property({ reflect: true }) hand: DrivingHand = readBrowserChoice(HAND_KEY, ["both", "left", "right"]);

  @state() private aside = false;

  private readonly interlocks = new ContextStoreController(this, interlocksContext, () => {
    this.seat?.followLock(this.lockReason);
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
    this.seat?.followLock(this.lockReason);
    const channels = [this.speedSignal, this.sidewaysSignal, this.turnSignal].flatMap((signal) => signal?.channels ?? []);
    this.live.observeChannels(this.site, channels);
  }

  override render(): TemplateResult | typeof nothing {
    const { seat } = this;
    const limits = this.device?.drive;
    if (!seat || !limits) return nothing;
    const { machine, lease, told } = seat;
    const state = lease.state;
    const idle = !machine.mayDrive;
    const sideways = limits.max_sideways > 0;
    const steers = limits.max_steering > 0;
    return html`
      ${renderLease(seat, { stopped: this.stopped, forces: this.device?.rights.includes("admin") ?? false })}
      <div class="hands" @t-hold=${this.onHold} @t-halt=${this.onHalt}>
        <t-pad ?disabled=${idle} .stickOf=${this.aside ? sidePadStick : padStick}></t-pad>
        <t-arrows ?disabled=${idle} ?sideways=${sideways} ?steers=${steers}></t-arrows>
      </div>
      ${sideways ? this.renderAside() : nothing}
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
        ?sideways=${sideways}
        ?steers=${steers}
        .shownSpeed=${limits.shown_speed}
        .shownTurn=${limits.shown_turn}
        .cap=${this.speedCapReason()}
        .refusal=${state.kind === "mine" && !this.stopped ? (told?.why ?? "") : ""}
      ></t-drive-readout>
      <div class="hand">
        <span>${msg("Thumb")}</span><t-choice label=${msg("Thumb that drives")} .options=${HANDS} .chosen=${this.hand} @t-choose=${this.onHand}></t-choice>
      </div>
      <div class="foot">
      <details class="hint">
        <summary>${msg("Keys and gamepad")}</summary>
        <p>
          ${steers ? sideways ? msg("Hold W\u00a0A\u00a0D\u00a0X or the arrow keys to drive, several at once for a curve; let go to halt. S halts, + and \u2212 change the speed, Escape is STOP. A and D steer, also while it stands; let go, the wheels stay turned until you drive on. Q and E move to the left and right without turning. Gamepad: hold a shoulder button and push the left stick or the cross, the right stick for sideways; the right thumb's lowest button halts, the right one is STOP, the left and the top one change the speed.") : msg("Hold W\u00a0A\u00a0D\u00a0X or the arrow keys to drive, several at once for a curve; let go to halt. S halts, + and \u2212 change the speed, Escape is STOP. A and D steer, also while it stands; let go, the wheels stay turned until you drive on. Gamepad: hold a shoulder button and push the left stick or the cross; the right thumb's lowest button halts, the right one is STOP, the left and the top one change the speed.") : sideways ? msg("Hold W\u00a0A\u00a0D\u00a0X or the arrow keys to drive, several at once for a curve; let go to halt. S halts, + and \u2212 change the speed, Escape is STOP. Q and E move to the left and right without turning. Gamepad: hold a shoulder button and push the left stick or the cross, the right stick for sideways; the right thumb's lowest button halts, the right one is STOP, the left and the top one change the speed.") : msg("Hold W\u00a0A\u00a0D\u00a0X or the arrow keys to drive, several at once for a curve; let go to halt. S halts, + and \u2212 change the speed, Escape is STOP. Gamepad: hold a shoulder button and push the left stick or the cross; the right thumb's lowest button halts, the right one is STOP, the left and the top one change the speed.")}
        </p>
      </details>
      ${this.renderPads()}
      <span class="loop" title=${msg("From this page to the gateway and back, measured while you have control")}
        >${msg(str`Round trip ${formatMs(told && told.loop_ms > 0 ? told.loop_ms : Number.NaN)}`)}</span
      >
      </div>
    `;
  }

  /** On a pad, left and right are either a turn or a move. */
  private renderAside(): TemplateResult {
    return html`<div class="aside">
      <span>${msg("Left and right on the pad")}</span>
      <t-choice label=${msg("Left and right on the pad")} .options=${PAD_WAYS} .chosen=${this.aside ? "move" : "turn"} @t-choose=${this.onAside}></t-choice>
    </div>`;
  }

  /** Whether a gamepad that is there can be driven by. */
  private renderPads(): unknown {
    const pads = navigator.getGamepads().filter((pad) => pad !== null);
    const found = padsFound(pads.map(({ mapping }) => mapping));
    if (found === "none") return nothing;
    return html`<span class="pads">${found === "ready" ? msg("Gamepad ready") : msg("This gamepad has a layout of its own: no driving by it")}</span>`;
  }

  /** Why an interlock refuses driving now; empty when none does. */
  private get lockReason(): string {
    if (this.rehearsing) return "";
    const lock = this.device && this.interlocks.store?.lockOf(this.site, this.device.id, "drive");
    return lock ? lockText(lock) : "";
  }

  private speedCapReason(): string {
    const { seat } = this;
    if (!seat?.told || seat.lease.state.kind !== "mine") return "";
    const slow = this.device && this.interlocks.store?.slowOf(this.site, this.device.id);
    return capWords(seat.told.cap, seat.told.loop_ms, this.pictureAge(), slow?.name);
  }

  private measuredMotion(): Motion {
    return { linear: this.freshValue(this.speedSignal), angular: this.freshValue(this.turnSignal), lateral: this.freshValue(this.sidewaysSignal) };
  }

  /** A stale one counts as none. */
  private freshValue(signal: SignalShape | undefined): number {
    const channel = signal?.channels[0];
    if (!signal || channel === undefined) return Number.NaN;
    const fresh = this.live.freshnessOf(channel, signal.max_age) === "live";
    return fresh ? (this.live.readingOf(channel)?.value ?? Number.NaN) : Number.NaN;
  }

  private get speedSignal(): SignalShape | undefined {
    return this.measuringSignal("vehicle.speed", "m/s") ?? this.plainSignal("m/s");
  }

  private get turnSignal(): SignalShape | undefined {
    return this.measuringSignal("vehicle.turn_rate", "rad/s") ?? this.plainSignal("rad/s");
  }

  private get sidewaysSignal(): SignalShape | undefined {
    return this.measuringSignal("vehicle.sideways_speed", "m/s");
  }

  /** Beside what is asked stands what is in the same unit. */
  private measuringSignal(role: SignalShape["role"], unit: string): SignalShape | undefined {
    return this.device?.signals.find((signal) => signal.role === role && signal.unit === unit);
  }

  /** The device's first number in this unit that is nothing else. */
  private plainSignal(unit: string): SignalShape | undefined {
    return this.device?.signals.find((signal) => signal.type === "number" && signal.unit === unit && !signal.role.startsWith("vehicle."));
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

  private readonly onHand = (event: CustomEvent<string>): void => {
    this.hand = HANDS.find(({ id }) => id === event.detail)?.id ?? "both";
    saveBrowserChoice(HAND_KEY, this.hand);
  };

  private readonly onAside = (event: CustomEvent<string>): void => {
    this.seat?.haltMotion("stop key");
    this.aside = event.detail === "move";
  };
}

const NO_MOTION: Motion = { linear: Number.NaN, angular: Number.NaN };

declare global {
  interface HTMLElementTagNameMap {
    "t-drive-pad": DrivePad;
  }
}
