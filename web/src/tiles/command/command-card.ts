/** One command as a form, tied to the connection: locks, rights and what became of it. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { CommandArguments, CommandClient } from "../../controllers/drive/command-client.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { StoreController } from "../../controllers/store-controller.js";
import "../../elements/command/command-form.js";
import { lockText } from "../../format/interlock-reason.js";
import { stateWord } from "../../format/state-label.js";
import { interlocksContext } from "../../state/contexts.js";
import type { CommandShape, DeviceShape } from "../../generated/api.js";
import { renderInterruptDialog } from "./interrupt-dialog.js";

@customElement("t-command-card")
export class CommandCard extends LitElement {
  static override styles = css`
    :host {
      display: block;
      min-inline-size: 0;
    }
  `;

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) command: CommandShape | null = null;
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) online = true;

  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly watched = new StoreController(this);
  private readonly live = new LiveValuesController(this);

  override willUpdate(): void {
    this.watched.setStore(this.line);
    this.live.observeChannels(this.site, this.command?.needs ? [this.command.needs.channel] : []);
  }

  override render(): TemplateResult | typeof nothing {
    const { device, command } = this;
    if (device === null || command === null) return nothing;
    const lock = this.interlocks.store?.lockOf(this.site, device.id, command.id) ?? null;
    const sendCommand = (event: CustomEvent<CommandArguments>): void => {
      const units = command.arguments.map(({ id, unit }) => [id, unit] as const);
      this.line?.sendCommand(device.id, command.id, event.detail, Object.fromEntries(units));
    };
    const cancelCommand = (): void => {
      this.line?.cancelCommand(device.id, command.id);
    };
    const asked = this.line?.desk.latestRequest(device.id, command.id) ?? null;
    return html`<t-command
      .command=${command}
      .asked=${asked}
      .online=${this.online}
      .locked=${lock === null ? this.stateText(command) : lockText(lock)}
      .allowed=${device.rights.includes("use")}
      @t-ask=${sendCommand}
      @t-cancel=${cancelCommand}
      ></t-command
      >${renderInterruptDialog([asked], this.line)}`;
  }

  /** Why a transition leads nowhere from the state that its node is in; empty where it does, or nobody knows. */
  private stateText({ needs }: CommandShape): string {
    if (!needs || this.live.freshnessOf(needs.channel, needs.max_age) !== "live") return "";
    const word = stateWord(needs.states, this.live.readingOf(needs.channel)?.value ?? Number.NaN);
    return needs.among.includes(word) ? "" : msg(str`Not possible now: it is ${word}`);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-command-card": CommandCard;
  }
}
