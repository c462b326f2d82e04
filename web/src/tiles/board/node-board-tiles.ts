/** What a description says of a robot's nodes as tiles: their parameters, and the states of their life cycles. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../../elements/base/base-style.js";
import type { CommandShape, DeviceShape, SignalShape } from "../../generated/api.js";
import "../command/command-card.js";
import "../signal-value.js";
import type { BoardTileContext } from "./board-tile-entry.js";

/** A signal with the commands that change it, of one device. */
export interface NodePart {
  readonly device: DeviceShape;
  readonly signal: SignalShape | null;
  readonly commands: readonly CommandShape[];
}

/** Parameters of each device, then what sets them: which sets which, only the robot knows. */
export function parameterParts(devices: readonly DeviceShape[]): readonly NodePart[] {
  return devices.flatMap((device) => [
    ...device.signals.filter(({ ros }) => ros === "parameter").map((signal) => ({ device, signal, commands: [] })),
    ...partWithout(device, device.commands.filter(({ ros }) => ros === "parameter")),
  ]);
}

/** Nodes with their transitions; such of which nobody may see the state last. */
export function lifecycleParts(devices: readonly DeviceShape[]): readonly NodePart[] {
  return devices.flatMap((device) => {
    const transitions = device.commands.filter(({ ros }) => ros === "lifecycle");
    const nodes = device.signals.filter(({ ros }) => ros === "lifecycle");
    const addresses = nodes.map(({ address }) => address);
    return [
      ...nodes.map((signal) => ({ device, signal, commands: transitions.filter(({ needs }) => needs?.channel === signal.address) })),
      ...partWithout(device, transitions.filter(({ needs }) => !addresses.includes(needs?.channel ?? ""))),
    ];
  });
}

function partWithout(device: DeviceShape, commands: readonly CommandShape[]): readonly NodePart[] {
  return commands.length === 0 ? [] : [{ device, signal: null, commands }];
}

const partStyle = css`
  :host {
    display: grid;
    align-content: start;
    gap: var(--t-space-2);
    min-inline-size: 0;
  }
  .row {
    display: flex;
    flex-wrap: wrap;
    align-items: baseline;
    justify-content: space-between;
    gap: 0 var(--t-space-3);
    --t-value-align: end;
  }
  .row > span:first-child {
    color: var(--t-muted);
    font-size: var(--t-size-s);
    overflow-wrap: anywhere;
  }
  .part {
    display: grid;
    gap: var(--t-space-2);
    padding-block: var(--t-space-1);
    border-block-start: 1px solid var(--t-line);
  }
  .part:first-child {
    border-block-start: 0;
  }
  .commands {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(min(12rem, 100%), 1fr));
    gap: var(--t-space-2);
  }
  p {
    color: var(--t-muted);
  }
`;

/** Parts below each other, each with its value and its commands. */
abstract class NodePartsTile extends LitElement {
  static override styles = [base, partStyle];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) devices: readonly DeviceShape[] = [];

  protected abstract parts(): readonly NodePart[];
  /** Said where there are none. */
  protected abstract renderNone(): TemplateResult;

  override render(): TemplateResult {
    const parts = this.parts();
    if (parts.length === 0) return this.renderNone();
    return html`${repeat(
      parts,
      ({ device, signal }) => `${device.id} ${signal?.id ?? ""}`,
      (part) => this.renderPart(part),
    )}`;
  }

  private renderPart({ device, signal, commands }: NodePart): TemplateResult {
    const { context } = this;
    return html`<div class="part">
      <div class="row">
        <span>${this.devices.length > 1 ? `${device.name}: ` : ""}${signal?.name ?? msg("More")}</span>
        ${signal === null ? nothing : html`<t-signal-value bare size="s" .site=${context?.site ?? ""} .signal=${signal}></t-signal-value>`}
      </div>
      ${commands.length === 0
        ? nothing
        : html`<div class="commands">
            ${repeat(
              commands,
              ({ id }) => id,
              (command) =>
                html`<t-command-card .site=${context?.site ?? ""} .device=${device} .command=${command} .line=${context?.line ?? null} .online=${context?.online ?? false}></t-command-card>`,
            )}
          </div>`}
    </div>`;
  }
}

@customElement("t-tile-parameters")
export class ParametersBoardTile extends NodePartsTile {
  protected override parts(): readonly NodePart[] {
    return parameterParts(this.devices);
  }

  protected override renderNone(): TemplateResult {
    return html`<p>
      ${msg(html`No parameter is open to you here. The description names them as signals, <code>source: {parameter: /node/name}</code>, and as commands, <code>kind: parameter</code>.`)}
    </p>`;
  }
}

@customElement("t-tile-lifecycle")
export class LifecycleBoardTile extends NodePartsTile {
  protected override parts(): readonly NodePart[] {
    return lifecycleParts(this.devices);
  }

  protected override renderNone(): TemplateResult {
    return html`<p>
      ${msg(html`No life-cycle node is open to you here. The description names them as signals, <code>source: {lifecycle: /node}</code>, and their transitions as commands, <code>kind: lifecycle</code>.`)}
    </p>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-parameters": ParametersBoardTile;
    "t-tile-lifecycle": LifecycleBoardTile;
  }
}
