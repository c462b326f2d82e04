/** Draws zones and lines over a camera's picture, and writes them into the site's description. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import type { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import type { PictureFit } from "../../elements/camera/camera-view.js";
import type { ShapeEdit, ShapeHandles } from "../../elements/camera/shape-handles.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, routerContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { isSiteAdmin } from "../../state/rights.js";
import { sitePath, zonesPath } from "../../state/router.js";
import { CameraMarks } from "../../tiles/camera/camera-marks.js";
import type { ChangeAnswer, DescriptionList, DescriptionText, FindingShape, SiteShape, StreamShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { isObject } from "../description/json-schema.js";
import { refusalAdvice } from "../description/refusal-advice.js";
import type { ShapeChange } from "./shape-list.js";
import { ShapeDraft } from "./shape-draft.js";
import { draftChange, sendDraft, type DraftChange } from "../description/draft-change.js";
import { gapsOf, MOST_EACH, type ShapeKind } from "./zone-shapes.js";
import { DescriptionsApi } from "../../wire/descriptions-api.js";
import "../../elements/camera/shape-handles.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "../../elements/forms/button.js";
import "../../tiles/camera/camera-tile.js";
import "../description/description-diff.js";
import "../description/description-problems.js";
import "./shape-list.js";

const WHOLE_FIT: PictureFit = { picture: { width: 4, height: 3 }, zoom: { scale: 1, x: 0, y: 0 } };
const COUNTED = ["person"];

/** What is drawn on, and from which version of the description. */
interface Canvas {
  readonly key: string;
  readonly known: DescriptionList;
  readonly from: DescriptionText;
}

@customElement("t-page-zones")
export class PageZones extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .stage {
        max-inline-size: 60rem;
      }
      .hint {
        max-inline-size: 60rem;
        color: var(--t-muted);
      }
    `,
  ];

  @property() site = "";

  @state() private draft: ShapeDraft | null = null;
  @state() private fit: PictureFit = WHOLE_FIT;
  @state() private findings: readonly FindingShape[] = [];
  /** What would be applied; null until the hub has checked it. */
  @state() private change: DraftChange | null = null;
  @state() private answer: ChangeAnswer | null = null;

  @query("t-shape-handles") private readonly handles!: ShapeHandles | null;
  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly canvas = new LoadController<Canvas>(this);
  private readonly marked = new CameraMarks(this, null);
  private readonly applying = new QuestionController<Canvas>(this, (_, action) => this.applyChange(action));
  /** Of which canvas the draft was made. */
  private drawnOf = "";

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined || this.site === "" || !this.mayDraw()) return;
    const edition = `${this.site} ${sites.catalogueOf(this.site)}`;
    this.detail.load(edition, () => sites.loadDetail(this.site));
    this.canvas.load(edition, () => this.loadCanvas(edition));
    const stream = this.stream();
    this.marked.setSubject(this.site, stream?.detect ?? null);
    const canvas = this.canvas.value;
    if (canvas === undefined || stream === undefined) return;
    const key = `${canvas.key} ${stream.address}`;
    // What somebody has drawn stays when the description changes below it: the hub says so at the end.
    const other = this.draft?.camera !== stream.address;
    if (key === this.drawnOf || (!other && this.draft?.isChanged === true)) return;
    this.drawnOf = key;
    this.draft = isObject(canvas.from.site) ? new ShapeDraft(canvas.from.site, stream.address, this.draft?.camera === stream.address ? this.draft.chosen : -1) : null;
    this.findings = [];
  }

  override render(): TemplateResult {
    return html`${renderPageHead(
        msg("Zones and lines"),
        msg("Drawn over the camera’s picture; signals count at them."),
        html`<div class="actions">
          ${this.renderCameras()}
          <a href=${sitePath(this.site, "cameras")}>${msg("Cameras")}</a>
        </div>`,
      )}
      ${this.mayDraw() ? renderLoaded(this.detail, msg("the cameras"), (detail) => this.renderSite(detail)) : this.renderForbidden()}`;
  }

  private renderForbidden(): TemplateResult {
    return html`<t-empty heading=${msg("This page is for admins of the site")} icon="lock">
      <p>${msg("Zones and lines are a part of the site’s description, which only an admin of the site changes. You see them over the camera’s picture.")}</p>
    </t-empty>`;
  }

  private renderCameras(): unknown {
    const cameras = this.streams();
    if (cameras.length < 2) return nothing;
    return html`<select aria-label=${msg("Camera")} @change=${this.onCamera}>
      ${renderOptions(cameras.map(({ address, name }): [string, string] => [address, name]), this.stream()?.address ?? "")}
    </select>`;
  }

  private renderSite(detail: SiteShape): unknown {
    const stream = this.stream();
    if (stream === undefined) {
      return html`<t-empty heading=${msg("No cameras")} icon="camera"><p>${msg("None of the site’s devices has a stream in its description.")}</p></t-empty>`;
    }
    return renderLoaded(this.canvas, msg("the description"), (canvas) => this.renderCanvas(detail, stream, canvas));
  }

  private renderCanvas(detail: SiteShape, stream: StreamShape, { known }: Canvas): TemplateResult {
    const { draft } = this;
    if (draft === null) {
      return html`<t-problem what=${msg("The description cannot be read.")} how=${msg("Mend it under Admin, Description, first.")}></t-problem>`;
    }
    const online = (this.sites.store?.siteRow(this.site)?.online ?? detail.online) && this.link.state === "open";
    const shape = draft.shapes[draft.chosen];
    return html`${known.editable ? nothing : this.renderClosed(known)}
      <div class="stage" @keydown=${this.onKeyDown}>
        <t-camera
          editing
          .site=${this.site}
          .stream=${stream.address}
          .name=${stream.name}
          .detect=${stream.detect}
          ?blurred=${stream.blurred}
          .online=${online}
          @t-picture-fit=${this.onFit}
          ><t-shape-handles
            slot="over"
            .shapes=${draft.shapes}
            .chosen=${draft.chosen}
            .gaps=${shape === undefined ? [] : gapsOf(shape)}
            .picture=${this.fit.picture}
            .zoom=${this.fit.zoom}
            @t-shape-edit=${this.onShapeEdit}
          ></t-shape-handles
        ></t-camera>
      </div>
      <section class="sheet" aria-label=${msg("What is drawn")} @keydown=${this.onKeyDown}>
        <div class="actions">
          <t-button ?disabled=${this.isFull("zone")} @click=${this.addZone}>${msg("Add zone")}</t-button>
          <t-button ?disabled=${this.isFull("line")} @click=${this.addLine}>${msg("Add line")}</t-button>
          <t-button kind="quiet" ?disabled=${!draft.canUndo} @click=${this.undo}>${msg("Undo")}</t-button>
          <t-button kind="quiet" ?disabled=${!draft.canRedo} @click=${this.redo}>${msg("Redo")}</t-button>
          <t-button kind="primary" ?disabled=${!this.canApply(known)} @click=${this.openReview}>${msg("Review and apply")}</t-button>
        </div>
        ${draft.shapes.length === 0
          ? html`<t-empty heading=${msg("Nothing is drawn yet")} icon="camera">
              <p>${msg("A zone counts who stands in it and for how long; a line counts who crosses it, to either side.")}</p>
            </t-empty>`
          : html`<p class="hint">${msg("Drag the points, or move them by arrow keys. What counts is where something stands: the middle of its lower edge. Draw a line where people are seen for a second on both sides.")}</p>
              <t-shape-list
                .shapes=${draft.shapes}
                .chosen=${draft.chosen}
                .marks=${this.marked.marks}
                .classes=${stream.detect?.classes ?? COUNTED}
                @t-shape-change=${this.onShapeChange}
                @t-shape-choose=${this.onShapeChosen}
              ></t-shape-list>`}
        ${stream.detect === null || stream.detect === undefined
          ? html`<p class="muted">${msg("Object detection is off on this camera. What you apply here switches it on.")}</p>`
          : nothing}
        ${this.findings.length === 0 ? nothing : html`<t-findings .findings=${this.findings}></t-findings>`}
      </section>
      ${this.renderReview()}`;
  }

  private renderClosed(known: DescriptionList): TemplateResult {
    if (!known.online) return html`<t-problem what=${msg("The site’s gateway is offline.")} how=${msg("What is drawn can be applied when it is back.")}></t-problem>`;
    const how = msg("Start it with --accept-changes readings, or write the zones into its file there.");
    return html`<t-problem what=${msg("The gateway takes no changes from here.")} how=${how}></t-problem>`;
  }

  private renderReview(): TemplateResult {
    const { answer, change, findings } = this;
    const wrong = [...findings, ...(answer?.findings ?? [])];
    return renderQuestion(this.applying, () => ({
      heading: msg("Apply these zones and lines?"),
      action: this.applying.action.runningKey === msg("apply what is drawn") ? msg("The gateway changes over…") : msg("Apply"),
      kind: "primary",
      problem: findings.length > 0 ? { what: msg("It cannot be applied as it is drawn."), how: msg("Close this, and change what is named here.") } : refusalAdvice(answer),
      text: html`${change === null
          ? nothing
          : html`<t-difference .parts=${change.parts} .lines=${change.lines}></t-difference>
              <p>${msg("The gateway applies it at once. The counts of this camera begin anew.")}</p>`}
        ${wrong.length === 0 ? nothing : html`<t-findings .findings=${wrong}></t-findings>`}`,
    }));
  }

  // ── what is there ──

  private mayDraw(): boolean {
    return isSiteAdmin(this.session.store?.person, this.site);
  }

  private streams(): readonly StreamShape[] {
    return (this.detail.value?.devices ?? []).flatMap(({ streams }) => streams);
  }

  /** The camera that the address names, or the first that looks for something. */
  private stream(): StreamShape | undefined {
    const asked = new URLSearchParams(this.router.store?.search ?? "").get("camera");
    const streams = this.streams();
    return streams.find(({ address }) => address === asked) ?? streams.find(({ detect }) => detect != null) ?? streams[0];
  }

  private isFull(kind: ShapeKind): boolean {
    return (this.draft?.shapes.filter((shape) => shape.kind === kind).length ?? 0) >= MOST_EACH;
  }

  private canApply(known: DescriptionList): boolean {
    const named = this.draft?.shapes.every(({ name }) => name.trim() !== "") === true;
    return known.editable && named && this.draft?.isChanged === true && !this.applying.action.busy;
  }

  private async loadCanvas(key: string): Promise<Canvas> {
    const api = new DescriptionsApi(this.api);
    const known = await api.listVersions(this.site);
    return { key, known, from: await api.versionText(this.site, known.versions[0]?.number ?? 0) };
  }

  // ── what a person does ──

  private readonly onFit = (event: CustomEvent<PictureFit>): void => {
    this.fit = event.detail;
  };

  private readonly onCamera = (event: Event): void => {
    this.router.store?.replace(zonesPath(this.site, (event.target as HTMLSelectElement).value));
  };

  private readonly onShapeEdit = (event: CustomEvent<ShapeEdit>): void => {
    this.draft?.applyEdit(event.detail);
    this.requestUpdate();
  };

  private readonly onShapeChange = (event: CustomEvent<ShapeChange>): void => {
    const { index, shape, along } = event.detail;
    this.draft?.replaceShape(index, shape, along);
    this.requestUpdate();
  };

  private readonly onShapeChosen = (event: CustomEvent<number>): void => {
    this.draft?.chooseShape(event.detail);
    this.requestUpdate();
  };

  private readonly addZone = (): void => {
    this.addShape("zone");
  };

  private readonly addLine = (): void => {
    this.addShape("line");
  };

  private addShape(kind: ShapeKind): void {
    this.draft?.addShape(kind, this.stream()?.detect?.classes[0] ?? COUNTED[0] ?? "");
    this.requestUpdate();
    void this.updateComplete.then(() => this.handles?.focusPoint(0));
  }

  private readonly undo = (): void => {
    this.draft?.undoEdit();
    this.requestUpdate();
  };

  private readonly redo = (): void => {
    this.draft?.redoEdit();
    this.requestUpdate();
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    // A field's own steps back are the browser's.
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.composedPath()[0] instanceof HTMLInputElement) return;
    const key = event.key.toLowerCase();
    if (key === "z" && !event.shiftKey) this.undo();
    else if (key === "y" || (key === "z" && event.shiftKey)) this.redo();
    else return;
    event.preventDefault();
  };

  private readonly openReview = (event: Event): void => {
    const { draft } = this;
    const canvas = this.canvas.value;
    if (draft === null || canvas === undefined) return;
    this.answer = this.change = null;
    this.findings = [];
    this.applying.opener(canvas)(event);
    void this.applying.action.run(msg("check what is drawn"), async () => {
      this.change = await draftChange(this.api, this.site, canvas.from, draft.described());
      this.findings = this.change.findings;
    });
  };

  /** Gives whether the gateway changed over. */
  private async applyChange(action: ActionController): Promise<boolean> {
    const { change } = this;
    this.answer = null;
    if (change === null || change.findings.length > 0) return false;
    const sent = await action.run(msg("apply what is drawn"), async () => {
      this.answer = await sendDraft(this.api, this.site, change);
    });
    const applied = sent && (this.answer as ChangeAnswer | null)?.phase === "applied";
    if (applied) {
      this.draft?.keepEdits();
      this.canvas.invalidate();
    }
    return applied;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-zones": PageZones;
  }
}
