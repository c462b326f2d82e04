/** A scene with what can be asked of the robot in it: a goal, where it stands, and STOP beside them. */

import { ContextConsumer } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { CommandClient } from "../../controllers/drive/command-client.js";
import { StopClient } from "../../controllers/drive/stop-client.js";
import { base } from "../../elements/base/base-style.js";
import type { SiteShape } from "../../generated/api.js";
import { filledCommand, poseCommands, type FloorPose, type PoseCommand } from "../../scene/pose-command.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { robotNewsContext } from "../../state/contexts.js";
import "../../elements/scene/scene.js";
import "../command/command-card.js";
import "../stop/stop-panel.js";

@customElement("t-scene-tile")
export class SceneTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      /* As high as its place. */
      :host([bare]) {
        grid-template-rows: minmax(0, 1fr);
        block-size: 100%;
        --t-scene-height: 100%;
        --t-scene-least: 6rem;
      }
      .ask {
        display: grid;
        grid-template-columns: minmax(0, 1fr) minmax(10rem, 16rem);
        align-items: start;
        gap: var(--t-space-3);
      }
      @media (max-width: 45rem) {
        .ask {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ type: Boolean }) online = false;
  /** Without lists and commands: in a small tile. */
  @property({ type: Boolean, reflect: true }) bare = false;
  @property({ attribute: false }) topics: readonly string[] = [];
  /** The past moment that is shown; null for now. */
  @property({ attribute: false }) past: PastBoard | null = null;
  @property() zone = "UTC";

  @state() private asked: { readonly tool: string; readonly pose: FloorPose } | null = null;
  private readonly link = new ConnectionStateController(this);
  private readonly news = new ContextConsumer(this, { context: robotNewsContext });
  private commands: CommandClient | null = null;
  private readonly stops = new Map<string, StopClient>();
  private built = "";

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.closeClients();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  protected override willUpdate(): void {
    const { connection } = this.link;
    const found = this.found();
    // Of a past moment nothing is asked of the robot.
    const wanted = connection && this.isConnected && this.past === null ? `${this.site} ${found.map(({ device }) => device.id).join(" ")}` : "";
    if (wanted === this.built) return;
    this.closeClients();
    this.built = wanted;
    if (!connection || found.length === 0 || wanted === "") return;
    this.commands = new CommandClient(connection, this.site);
    this.commands.open();
    for (const { device } of found) {
      if (device.drive === null || this.stops.has(device.id)) continue;
      const stop = new StopClient(connection, this.site, device.id, this.online);
      stop.open(this.news.value?.stopOf(this.site, device.id));
      this.stops.set(device.id, stop);
    }
  }

  override render(): TemplateResult {
    // Who may not use the device sees the scene without them, as everywhere.
    const usable = this.past === null ? this.found().filter(({ device }) => device.rights.includes("use")) : [];
    const tools = usable.map(({ device, command }) => ({ id: `${device.id}/${command.id}`, label: command.name }));
    return html`<t-scene .site=${this.site} .online=${this.online} .bare=${this.bare} .topics=${this.topics} .past=${this.past} zone=${this.zone} .poseTools=${this.bare ? [] : tools} @t-pose=${this.onPose}></t-scene>
      ${this.bare || (usable.length === 0 && this.stops.size === 0) ? nothing : this.renderAsk(usable)}`;
  }

  private renderAsk(usable: readonly PoseCommand[]): TemplateResult {
    const chosen = usable.find(({ device, command }) => `${device.id}/${command.id}` === this.asked?.tool);
    return html`<div class="ask">
      <div>
        ${chosen === undefined || this.asked === null
          ? nothing
          : repeat(
              [this.asked],
              ({ tool, pose }) => `${tool} ${JSON.stringify(pose)}`,
              ({ pose }) => html`<t-command-card .site=${this.site} .device=${chosen.device} .command=${filledCommand(chosen.command, pose)} .line=${this.commands} .online=${this.online}></t-command-card>`,
            )}
      </div>
      <div>${repeat(this.stops, ([device]) => device, ([, stop]) => html`<t-stop-bar .line=${stop}></t-stop-bar>`)}</div>
    </div>`;
  }

  private found(): readonly PoseCommand[] {
    return poseCommands(this.detail?.devices ?? []);
  }

  private closeClients(): void {
    this.commands?.close();
    this.commands = null;
    for (const stop of this.stops.values()) stop.close();
    this.stops.clear();
    this.built = "";
  }

  private readonly onPose = (event: CustomEvent<{ tool: string; pose: FloorPose }>): void => {
    this.asked = event.detail;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-scene-tile": SceneTile;
  }
}
