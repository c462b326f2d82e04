/** A digital twin: how far it is from the robot, what is driven in it, its rehearsal, and STOP of the robot. */

import { ContextConsumer } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { keyed } from "lit/directives/keyed.js";
import { map } from "lit/directives/map.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { CommandClient } from "../../controllers/drive/command-client.js";
import { DriveController } from "../../controllers/drive/drive-controller.js";
import { TwinLink } from "../../controllers/drive/twin-link.js";
import { base } from "../../elements/base/base-style.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/twin/rehearsal-map.js";
import { fixedText } from "../../format/number.js";
import type { DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import { filledCommand, poseCommands, type FloorPose } from "../../scene/pose-command.js";
import { pathPoses, verdictLines } from "../../scene/rehearsal.js";
import { robotNewsContext } from "../../state/contexts.js";
import "../command/command-card.js";
import "../drive/drive-pad.js";
import "../signal-value.js";
import "../stop/stop-panel.js";
import { twinStyle } from "./twin-style.js";

/** In which the gateway has the path: that of the robot's odometry. */
const FRAME = "odom";
const SHOWN = ["mode", "pose_error", "heading_error", "speed_error"] as const;

@customElement("t-twin")
export class TwinTile extends LitElement {
  static override styles = [base, twinStyle];

  @property() site = "";
  /** The twin's own device. */
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) online = false;

  /** The pose that is about to be sent; null: none. */
  @state() private goal: FloorPose | null = null;

  private readonly news = new ContextConsumer(this, { context: robotNewsContext });
  private readonly link = new ConnectionStateController(this);
  private controller: DriveController | null = null;
  private twin: TwinLink | null = null;
  /** The real device may be used by who may not use the twin: its commands have a line of their own. */
  private commands: CommandClient | null = null;
  private unwatch: (() => void)[] = [];
  private built = "";

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.closeAll();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  protected override willUpdate(): void {
    const { connection } = this.link;
    const real = this.realDevice;
    const wanted = connection !== undefined && real?.drive && this.isConnected ? `${this.site} ${JSON.stringify(real)}` : "";
    if (wanted === this.built) return;
    this.closeAll();
    this.built = wanted;
    if (wanted === "" || connection === undefined || real === undefined) return;
    const twin = new TwinLink(connection, this.site, real.id, () => {
      this.controller?.seat?.haltMotion("cancelled");
    });
    const controller = new DriveController(connection, this.site, real, this.online, twin.messageOf);
    const known = this.news.value;
    twin.open(known?.twinOf(this.site, real.id));
    controller.openAll({ lease: known?.leaseOf(this.site, real.id), stop: known?.stopOf(this.site, real.id), heldStop: known?.heldStopOf(this.site, real.id) });
    this.commands = new CommandClient(connection, this.site);
    this.commands.open();
    [this.twin, this.controller] = [twin, controller];
    const redraw = (): void => {
      this.requestUpdate();
    };
    this.unwatch = [twin.subscribe(redraw), controller.stop.subscribe(redraw), ...(controller.seat === null ? [] : [controller.seat.subscribe(redraw)])];
  }

  override render(): TemplateResult | typeof nothing {
    const { device, controller, twin } = this;
    const real = this.realDevice;
    if (device === null) return nothing;
    if (real === undefined) return html`<t-empty heading=${msg("Not open to you")} icon="lock"><p>${msg("You may not see the robot that this is the twin of.")}</p></t-empty>`;
    return html`<section aria-labelledby="difference">
        <h2 id="difference">${msg(str`Difference to ${real.name}`)}</h2>
        <div class="values">
          ${map(SHOWN, (id) => html`<t-signal-value .site=${this.site} .signal=${this.signalOf(id)} size="l"></t-signal-value>`)}
        </div>
        <p class="muted">${msg("The robot less its twin. A twin that is too far away for too long is put where the robot is.")}</p>
      </section>
      ${controller === null || twin === null ? nothing : html`<div class="columns">${this.renderHands(real, controller, twin)} ${this.renderRehearsal(real, twin)}</div>`}`;
  }

  private renderHands(real: DeviceShape, controller: DriveController, twin: TwinLink): TemplateResult {
    const { seat, stop } = controller;
    return html`<section class="hands" aria-labelledby="drive">
      <h2 id="drive">${msg("Drive")}</h2>
      <t-stop-bar .line=${stop}></t-stop-bar>
      <t-stop .line=${stop} .zone=${this.detail?.zone ?? "UTC"} .epoch=${seat?.lease.epoch ?? 0} .mayUse=${real.rights.includes("use")}></t-stop>
      ${seat === null
        ? html`<p>${msg(html`Driving the twin needs the right <strong>use</strong> for ${real.name}. STOP works for everyone who sees it.`)}</p>`
        : html`${this.renderSwitch(real, seat.lease.epoch, twin)}
            <t-drive-pad .site=${this.site} .device=${real} .seat=${seat} .stopped=${stop.desk.blocksDriving} ?rehearsing=${!twin.isLive}></t-drive-pad>`}
    </section>`;
  }

  private renderSwitch(real: DeviceShape, epoch: number, twin: TwinLink): TemplateResult {
    const { told, isLive } = twin;
    const change = (event: Event): void => {
      const box = event.currentTarget as HTMLInputElement;
      const { checked } = box;
      // It shows what is so, and that says the gateway.
      box.checked = isLive;
      twin.setLive(checked, epoch);
    };
    return html`<div class="switch ${isLive ? "live" : ""}">
        <label><input type="checkbox" role="switch" .checked=${isLive} ?disabled=${epoch === 0} @change=${change} /> ${msg("Live")}</label>
        <t-status kind=${isLive ? "warn" : "ok"} word=${isLive ? msg(str`${real.name} moves`) : msg("only the twin moves")}></t-status>
      </div>
      <p class="muted">
        ${epoch === 0
          ? msg("Take control first: there is one lease for both.")
          : isLive
            ? msg(str`What you drive here goes to ${real.name}, and the twin follows it.`)
            : msg(str`What you drive here moves the twin alone. Live sends it to ${real.name}, too.`)}
      </p>
      <p class="trouble" role="status">${told?.live === true && !isLive ? msg(str`Live for ${told.who}, in another window`) : (told?.why ?? "")}</p>`;
  }

  private renderRehearsal(real: DeviceShape, twin: TwinLink): TemplateResult {
    const { told } = twin;
    const poses = pathPoses(told?.path ?? [], FRAME);
    if (told === null || poses.length === 0) {
      return html`<section aria-labelledby="rehearsal"><h2 id="rehearsal">${msg("Rehearsal")}</h2>
        <t-empty heading=${msg("Nothing rehearsed yet")} icon="drive"><p>${msg("Drive the twin with live switched off: its path stands here, with what interlocks would have said.")}</p></t-empty></section>`;
    }
    const lines = verdictLines(told);
    const summary = msg(str`${fixedText(told.metres, 2)} m in ${told.seconds.toFixed(0)} s`);
    return html`<section aria-labelledby="rehearsal">
      <h2 id="rehearsal">${msg("Rehearsal")}</h2>
      <t-rehearsal-map .poses=${poses} .verdicts=${told.verdicts} label=${msg(str`Path of the rehearsal: ${summary}`)}></t-rehearsal-map>
      <p>${summary}</p>
      ${lines.length === 0
        ? html`<p><t-status kind="ok" word=${msg("Nothing would have been refused")}></t-status></p>`
        : html`<ul>${map(lines, (line) => html`<li>${line}</li>`)}</ul>`}
      <p class="muted">${msg(str`By what is so now: weather, batteries and people may be others when ${real.name} drives there.`)}</p>
      ${this.renderDeeds(real)}
    </section>`;
  }

  private renderDeeds(real: DeviceShape): unknown {
    const seat = this.controller?.seat;
    if (seat === null || seat === undefined) return nothing;
    const command = poseCommands([real]).find(({ role }) => role === "vehicle.goal")?.command;
    const follow = this.device?.commands.find(({ id }) => id === "follow");
    const { epoch } = seat.lease;
    return html`<div class="deeds">
        ${command === undefined
          ? html`<p class="muted">${msg(html`${real.name} has no command of the role <code>vehicle.goal</code>: the path cannot be sent to it.`)}</p>`
          : html`<t-button kind="primary" @click=${this.openGoal}>${msg("Send as a goal…")}</t-button>`}
        ${follow === undefined ? nothing : html`<t-button ?disabled=${this.line === null} @click=${this.followRobot}>${msg("Follow the robot again")}</t-button>`}
        <t-button ?disabled=${epoch === 0} @click=${this.forgetPath}>${msg("Forget the path")}</t-button>
      </div>
      ${this.goal === null || command === undefined
        ? nothing
        : keyed(
            JSON.stringify(this.goal),
            html`<t-command-card .site=${this.site} .device=${real} .command=${filledCommand(command, this.goal)} .line=${this.commands} .online=${this.online}></t-command-card>`,
          )}`;
  }

  private readonly openGoal = (): void => {
    this.goal = pathPoses(this.twin?.told?.path ?? [], FRAME).at(-1) ?? null;
  };

  private readonly forgetPath = (): void => {
    this.goal = null;
    this.twin?.clearRehearsal(this.controller?.seat?.lease.epoch ?? 0);
  };

  private readonly followRobot = (): void => {
    if (this.device !== null) this.line?.sendCommand(this.device.id, "follow", {});
  };

  private get realDevice(): DeviceShape | undefined {
    return this.detail?.devices.find(({ id }) => id === this.device?.twin_of);
  }

  private signalOf(id: string): SignalShape | null {
    return this.device?.signals.find((signal) => signal.id === id) ?? null;
  }

  private closeAll(): void {
    for (const stop of this.unwatch) stop();
    this.unwatch = [];
    this.controller?.closeAll();
    this.twin?.close();
    this.commands?.close();
    [this.controller, this.twin, this.commands, this.built] = [null, null, null, ""];
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-twin": TwinTile;
  }
}
