/** A robot's nodes and topics as a tile: asked for while it is looked at. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import type { GraphShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { TopicsApi } from "../../topics/topics-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/empty.js";
import "../../elements/topic/node-graph.js";
import type { BoardTileContext } from "./board-tile-entry.js";

/** The robot goes on listing its nodes for as long as it is asked so often (ms). */
const AGAIN_MS = 5000;

@customElement("t-tile-graph")
export class GraphBoardTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: auto minmax(0, 1fr);
        gap: var(--t-space-2);
        block-size: 100%;
        min-block-size: 0;
      }
      t-node-graph {
        grid-row: 2;
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property() around = "";

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly graph = new LoadController<GraphShape>(this);
  private timer: ReturnType<typeof setInterval> | undefined;
  /** The last that had nodes: a gateway that is away takes nothing from it. */
  private known: GraphShape | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      if (!document.hidden) this.graph.invalidate();
    }, AGAIN_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  protected override willUpdate(): void {
    const { api, context } = this;
    if (api === undefined || context === null) return;
    const { site } = context;
    this.graph.load(site, () => new TopicsApi(api, site).readGraph());
    const found = this.graph.value;
    if (found !== undefined && (found.nodes.length > 0 || found.online)) this.known = found;
  }

  override render(): TemplateResult {
    const { known } = this;
    if (known === null && this.graph.result.state !== "ready") return html`${renderLoaded(this.graph, msg("the nodes"), () => nothing)}`;
    if (known === null) return html`<t-empty heading=${msg("The gateway is away")} icon="unlinked"><p>${msg("The nodes appear by themselves when the robot's gateway has connected.")}</p></t-empty>`;
    if (known.nodes.length === 0) {
      return html`<t-empty heading=${msg("No nodes to show")} icon="devices">
        <p>${msg(html`No node of the robot has a topic that you may follow, or its connection lists none. An admin opens topics in the site's description, under <code>topics:</code>, or gives you the right <strong>tap</strong>.`)}</p>
      </t-empty>`;
    }
    const old = this.context?.online !== true ? html`<t-banner kind="warn">${msg("The robot's gateway is not connected: these are the nodes that it had.")}</t-banner>` : this.graph.result.state === "failed" ? html`<t-banner kind="warn">${msg("The hub does not answer: these are the nodes of before.")}</t-banner>` : nothing;
    return html`${old}<t-node-graph .nodes=${known.nodes} around=${this.around}></t-node-graph>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-graph": GraphBoardTile;
  }
}
