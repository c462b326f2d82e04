/** An arm: itself in space, its joints between their ends, steps of its tool, and its named poses. */

import { msg } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { isFinal } from "../../controllers/drive/command-machine.js";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base } from "../../elements/base/base-style.js";
import { shownText } from "../../format/unit.js";
import type { CommandShape, SignalShape } from "../../generated/api.js";
import { DevicePart, partStyle } from "../observatory/device-part.js";
import type { CommandButton } from "../observatory/roles.js";
import { armParts, isNearEnd, jogButtons, jointShare, type ArmParts } from "./arm-parts.js";
import "../../elements/drive/joint-bar.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../command/command-buttons.js";
import "../scene/scene-tile.js";
import "./joint-jog.js";

const STEPS = [
  { id: "0.1", label: msg("Small") },
  { id: "0.5", label: msg("Middle") },
  { id: "1", label: msg("Full") },
] as const;

@customElement("t-arm-cockpit")
export class ArmCockpit extends DevicePart {
  static override styles = [
    base,
    partStyle,
    css`
      .cockpit {
        display: grid;
        grid-template: "scene side" auto / minmax(0, 1fr) minmax(22rem, 30rem);
        gap: var(--t-space-4);
        align-items: start;
      }
      .scene {
        grid-area: scene;
        block-size: clamp(18rem, 70dvh, 50rem);
      }
      .side {
        grid-area: side;
        display: grid;
        gap: var(--t-space-4);
      }
      h2 {
        font-size: var(--t-size-m);
      }
      .joints {
        display: grid;
        gap: var(--t-space-3);
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        justify-content: space-between;
        gap: var(--t-space-2);
      }
      @media (max-width: 60rem) {
        .cockpit {
          grid-template: "scene" auto "side" auto / minmax(0, 1fr);
        }
        .scene {
          block-size: 45dvh;
        }
      }
    `,
  ];

  /** Of an arm whose joints are driven, for who may drive them. */
  @property({ attribute: false }) seat: DriveSession | null = null;
  @property({ type: Boolean }) stopped = false;
  /** Begins with the smallest: an arm is near what it works on. */
  @state() private step: string = STEPS[0].id;
  private readonly watched = new StoreController(this);

  override willUpdate(): void {
    this.watched.setStore(this.line);
    this.observeSignals(...(this.parts()?.joints ?? []));
  }

  override render(): TemplateResult | typeof nothing {
    const parts = this.parts();
    if (parts === null) return nothing;
    return html`<div class="cockpit">
      <t-scene-tile class="scene" bare .site=${this.site} .detail=${this.detail} .online=${this.online}></t-scene-tile>
      <div class="side">
        ${this.seat === null
          ? html`<section class="card" aria-label=${msg("Joints")}>
              <h2>${msg("Joints")}</h2>
              <div class="joints">${repeat(parts.joints, ({ address }) => address, (joint) => this.renderJoint(joint))}</div>
            </section>`
          : html`<section class="card" aria-label=${msg("Joints")}>
              <h2>${msg("Joints")}</h2>
              <t-joint-jog .site=${this.site} .device=${this.device} .seat=${this.seat} .stopped=${this.stopped}></t-joint-jog>
            </section>`}
        ${this.mayUse ? html`${this.renderPoses(parts)} ${this.renderJog(parts)}` : html`<div class="card">${this.renderLookOnly()}</div>`}
        ${this.device?.drive ? nothing : html`<p class="note">${msg("This arm has no STOP (software) here: keep the stop on the robot in reach. What is under way can be cancelled where its controller can.")}</p>`}
      </div>
    </div>`;
  }

  private renderJoint(joint: SignalShape): TemplateResult {
    const { fresh, value } = this.readSignal(joint);
    const share = fresh ? jointShare(joint, value) : Number.NaN;
    return html`<t-joint
      .name=${joint.name}
      .value=${fresh ? shownText(joint, value) : ""}
      .low=${shownText(joint, joint.minimum ?? Number.NaN)}
      .high=${shownText(joint, joint.maximum ?? Number.NaN)}
      .share=${share}
      ?near=${isNearEnd(share)}
    ></t-joint>`;
  }

  private renderPoses({ poses }: ArmParts): unknown {
    if (poses.length === 0) return nothing;
    const deeds = poses.map((command): CommandButton => ({ command, args: {}, label: command.name, kind: "plain" }));
    return html`<section class="card" aria-label=${msg("Poses")}>
      <h2>${msg("Poses")}</h2>
      ${this.renderDeeds(deeds)} ${map(poses, (pose) => this.renderCancel(pose))}
    </section>`;
  }

  private renderJog({ jog }: ArmParts): unknown {
    if (jog === null) return nothing;
    return html`<section class="card" aria-label=${msg("Jog")}>
      <div class="head">
        <h2>${msg("Jog")}</h2>
        <t-choice label=${msg("Step")} .options=${STEPS} .chosen=${this.step} @t-choose=${this.onStep}></t-choice>
      </div>
      <p class="note">${jog.description}</p>
      ${this.renderDeeds(jogButtons(jog, Number(this.step)))}
    </section>`;
  }

  private renderDeeds(deeds: readonly CommandButton[]): TemplateResult {
    return html`<t-deeds .site=${this.site} .device=${this.device} .line=${this.line} .deeds=${deeds} .online=${this.online}></t-deeds>`;
  }

  private renderCancel({ id, name, cancellable }: CommandShape): unknown {
    const device = this.device?.id ?? "";
    const asked = this.line?.desk.latestRequest(device, id) ?? null;
    if (!cancellable || asked === null || isFinal(asked.phase)) return nothing;
    const cancel = (): void => {
      this.line?.cancelCommand(device, id);
    };
    return html`<t-button kind="danger" ?disabled=${!this.online} @click=${cancel}>${msg("Cancel:")} ${name}</t-button>`;
  }

  private parts(): ArmParts | null {
    return this.device === null ? null : armParts(this.device);
  }

  private readonly onStep = (event: CustomEvent<string>): void => {
    this.step = event.detail;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-arm-cockpit": ArmCockpit;
  }
}
