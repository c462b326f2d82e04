/** Joints of an arm that move while a button is held: lease, speed, and two ways for each joint. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import { jointPush } from "../../controllers/drive/stick.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import "../../elements/drive/hold-button.js";
import "../../elements/drive/joint-bar.js";
import "../../elements/drive/speed-limit.js";
import type { HoldDetail } from "../../elements/drive/hold-event.js";
import { lockText } from "../../format/interlock-reason.js";
import { shownText } from "../../format/unit.js";
import type { DeviceShape, DrivenJointShape } from "../../generated/api.js";
import { interlocksContext } from "../../state/contexts.js";
import { renderLease } from "../drive/session-lease.js";
import { isNearEnd, jointShare } from "./arm-parts.js";

const DRAW_EVERY_MS = 200;

@customElement("t-joint-jog")
export class JointJog extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      .joint {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr) auto;
        align-items: center;
        gap: var(--t-space-3);
      }
      .trouble {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .trouble:empty {
        display: none;
      }
      .note {
        ${quietText}
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) seat: DriveSession | null = null;
  @property({ type: Boolean }) stopped = false;

  private readonly interlocks = new ContextStoreController(this, interlocksContext, () => {
    this.seat?.followLock(this.lockReason);
  });
  private readonly live = new LiveValuesController(this);
  private readonly watched = new StoreController(this);

  constructor() {
    super();
    new TickerController(this, DRAW_EVERY_MS);
  }

  override willUpdate(): void {
    this.watched.setStore(this.seat);
    this.seat?.followLock(this.lockReason);
    const named = (this.device?.drive?.joints ?? []).map(({ position }) => this.signalOf(position));
    this.live.observeChannels(this.site, named.flatMap((signal) => signal?.channels ?? []));
  }

  override render(): TemplateResult | typeof nothing {
    const { seat } = this;
    const joints = this.device?.drive?.joints ?? [];
    if (!seat || joints.length === 0) return nothing;
    const { machine, lease, told } = seat;
    const state = lease.state;
    const refusal = state.kind === "mine" && !this.stopped ? (told?.why ?? "") : "";
    return html`
      ${renderLease(seat, { stopped: this.stopped, forces: this.device?.rights.includes("admin") ?? false })}
      <div class="joints" role="group" aria-label=${msg("Hold to move a joint")} @t-hold=${this.onHold}>
        ${repeat(joints, ({ id }) => id, (joint, index) => this.renderJoint(joint, index, joints.length, !machine.mayDrive))}
      </div>
      <p class="trouble" role="alert">${this.lockReason || seat.problem || (refusal === "" ? "" : msg(str`Gateway: ${refusal}`))}</p>
      <t-speed-limit .level=${machine.speedLevel} .means=${speedWords(joints, machine.speedLevel)} @t-level=${this.onSpeedLevel}></t-speed-limit>
      <p class="note">${msg("A joint moves while its button is held, and comes to rest when it is let go. S halts, Escape is STOP.")}</p>
    `;
  }

  private renderJoint(joint: DrivenJointShape, index: number, count: number, idle: boolean): TemplateResult {
    const signal = this.signalOf(joint.position);
    const channel = signal?.channels[0];
    const fresh = signal !== undefined && channel !== undefined && this.live.freshnessOf(channel, signal.max_age) === "live";
    const value = fresh ? (this.live.readingOf(channel)?.value ?? Number.NaN) : Number.NaN;
    const share = jointShare(joint, value);
    const unit = signal ?? { unit: joint.slides ? "m" : "rad", decimals: 2, shown: null };
    return html`<div class="joint">
      <t-hold-button ?disabled=${idle} label=${msg(str`${joint.name}, down`)} name=${`joint:${joint.id}:-`} .stick=${jointPush(index, count, -1)}>−</t-hold-button>
      <t-joint
        .name=${joint.name}
        .value=${fresh ? shownText(unit, value) : ""}
        .low=${joint.minimum === null ? "" : shownText(unit, joint.minimum)}
        .high=${joint.maximum === null ? "" : shownText(unit, joint.maximum)}
        .share=${share}
        ?near=${isNearEnd(share)}
      ></t-joint>
      <t-hold-button ?disabled=${idle} label=${msg(str`${joint.name}, up`)} name=${`joint:${joint.id}:+`} .stick=${jointPush(index, count, 1)}>+</t-hold-button>
    </div>`;
  }

  private signalOf(address: string): DeviceShape["signals"][number] | undefined {
    return this.device?.signals.find((signal) => signal.address === address);
  }

  private get lockReason(): string {
    const lock = this.device && this.interlocks.store?.lockOf(this.site, this.device.id, "drive");
    return lock ? lockText(lock) : "";
  }

  private readonly onHold = ({ detail: { act, source, stick, kind } }: CustomEvent<HoldDetail>): void => {
    if (act === "press") this.seat?.pressHold(source, stick, kind);
    else if (act === "release") this.seat?.releaseHold(source);
    else if (act === "cancel") this.seat?.cancelHold(source);
  };

  private readonly onSpeedLevel = (event: CustomEvent<number>): void => {
    this.seat?.setLevel(event.detail);
  };
}

/** How fast the fastest joint moves at a full push; of joints that slide, beside those that turn. */
function speedWords(joints: readonly DrivenJointShape[], level: number): string {
  const ofKind = (slides: boolean): readonly string[] => {
    const limits = joints.filter((joint) => joint.slides === slides).map(({ max_speed: limit }) => limit);
    if (limits.length === 0) return [];
    const text = shownText({ unit: slides ? "m/s" : "rad/s", decimals: 2, shown: null }, Math.max(...limits) * level);
    return [new Set(limits).size > 1 ? msg(str`up to ${text}`) : text];
  };
  return [...ofKind(false), ...ofKind(true)].join(" · ");
}

declare global {
  interface HTMLElementTagNameMap {
    "t-joint-jog": JointJog;
  }
}
