/** A robot in space as its topics tell: frames, model, scans, clouds, maps, paths and markers. It stands by itself: a page and a tile give it a site. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { TickerController } from "../../controllers/ticker.js";
import { formatAge } from "../../format/duration.js";
import { StoreController } from "../../controllers/store-controller.js";
import { fixedText } from "../../format/number.js";
import type { TopicTable } from "../../generated/api.js";
import type { CloudColour } from "../../scene/cloud.js";
import type { FrameRow } from "../../scene/frame-tree.js";
import type { FloorPose } from "../../scene/pose-command.js";
import type { OpenPictures } from "../../scene/stream-pictures.js";
import { chooseFixedFrame, chooseRobotFrame, isSwitched } from "../../scene/scene-topics.js";
import type { Vector } from "../../scene/transform.js";
import { apiContext, socketsContext } from "../../state/contexts.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { bytesOver, type OpenBytes } from "../../topics/byte-topics.js";
import { openPastBytes } from "../../topics/past-bytes.js";
import { TopicsApi } from "../../topics/topics-api.js";
import { FilmPicturesApi, FilmsApi } from "../../wire/films-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { base } from "../base/base-style.js";
import { renderLoaded } from "../feedback/load-state.js";
import { control } from "../forms/input-style.js";
import { CameraPictures } from "./camera-pictures.js";
import type { SceneDrawing } from "./drawing.js";
import { FilmPictures } from "./film-pictures.js";
import { sceneColours } from "./scene-colours.js";
import { lengthOf, ScenePointer, type ScenePreview } from "./scene-pointer.js";
import { SceneSession, type SceneTopic, type SceneTopicEntry } from "./scene-session.js";
import { sceneStyle } from "./scene-style.js";
import "../feedback/banner.js";
import "../feedback/empty.js";
import "../feedback/loading.js";
import "../forms/button.js";
import "../topic/unrecorded.js";

/** Topics come and go (ms). */
const AGAIN_MS = 5000;
/** A frame that is not said for so long (s) is old. */
const OLD_S = 2;

/** What makes the picture's corners round; see the style. */
const CORNERS = html`<i class="corner nw"></i><i class="corner ne"></i><i class="corner sw"></i><i class="corner se"></i>`;

/** A tool that gives a place with a heading: a button's name by what `t-pose` says. */
export interface PoseTool {
  readonly id: string;
  readonly label: string;
}

/** @fires t-pose detail: `{ tool, pose }`, a place on the floor with a heading */
@customElement("t-scene")
export class SceneElement extends LitElement {
  static override styles = [base, control, sceneStyle];

  @property() site = "";
  /** The site's gateway is connected. */
  @property({ type: Boolean }) online = false;
  /** Without the list beside it: in a tile. */
  @property({ type: Boolean, reflect: true }) bare = false;
  /** Of the topics with layers only these; none: all that there are. */
  @property({ attribute: false }) topics: readonly string[] = [];
  @property({ attribute: false }) poseTools: readonly PoseTool[] = [];
  /** The past moment that is shown; null for now. */
  @property({ attribute: false }) past: PastBoard | null = null;
  @property() zone = "UTC";
  /** What follows a topic; none: a socket to the hub. */
  @property({ attribute: false }) openTopic: OpenBytes | undefined;

  @consume({ context: apiContext }) private api: HubApi | undefined;
  @consume({ context: socketsContext }) private readonly sockets: ((url: string) => WebSocket) | undefined;
  @query("canvas") private readonly canvas!: HTMLCanvasElement | null;
  @state() private tool = "";
  @state() private follow = true;
  @state() private preview: ScenePreview = null;
  @state() private fixedChoice = "";
  @state() private cloudBy: CloudColour = "height";
  @state() private showFrames = false;
  @state() private noSpace = "";
  @state() private trouble = "";
  private readonly table = new LoadController<TopicTable>(this);
  private readonly watched = new StoreController(this);
  private known: { readonly topics: readonly SceneTopicEntry[] } | undefined;
  /** Of a past moment: no recording holds it. */
  private unrecorded = false;
  private resetJumps = -1;
  private session: SceneSession | null = null;
  private drawing: SceneDrawing | null = null;
  private pointer: ScenePointer | null = null;
  private building = false;
  private timer: ReturnType<typeof setInterval> | undefined;
  private sizes: ResizeObserver | null = null;
  private themes: MutationObserver | null = null;

  constructor() {
    super();
    new TickerController(this);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      if (!document.hidden) this.table.invalidate();
    }, AGAIN_MS);
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.closeAll();
  }

  /** For tests and measuring: frames drawn, and where a topic's points are drawn (m, and px on the canvas). */
  drawn(topic: string): { readonly painted: number; readonly points: readonly Vector[]; readonly px: readonly { readonly x: number; readonly y: number }[] } {
    const points = this.drawing?.pointsOf(topic) ?? [];
    return { painted: this.drawing?.painted ?? 0, points, px: points.map((point) => this.drawing?.canvasPlace(point) ?? { x: 0, y: 0 }) };
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    const { api, site } = this;
    if (changed.has("site")) {
      this.closeAll();
      this.known = undefined;
    }
    this.watched.setStore(this.past);
    if (api === undefined || site === "") return;
    if (this.past !== null) this.lookBack(this.past);
    else {
      this.table.load(`${site} ${String(this.online)}`, () => new TopicsApi(api, site).listTopics());
      if (this.table.result.state === "ready") this.known = this.table.result.value;
    }
    if (this.known === undefined || !this.isConnected) return;
    const listener = {
      onChange: () => this.drawing?.schedule(),
      onState: () => {
        this.requestUpdate();
      },
    };
    this.session ??= new SceneSession(site, listener, {
      open: this.past === null ? (this.openTopic ?? bytesOver(this.sockets)) : openPastBytes(this.past, this.onPastReset),
      nowMs: this.past?.nowMs,
      openPictures: this.picturesOf(api, this.past),
    });
    this.session.setTopics(this.known.topics, this.topics);
  }

  protected override updated(): void {
    if (this.canvas !== null && this.session !== null && this.drawing === null && !this.building) void this.build(this.canvas, this.session);
    this.applyOptions();
  }

  override render(): TemplateResult {
    const { session } = this;
    if (this.past !== null && (this.known === undefined || session === null || session.topics.length === 0)) return this.renderPastEmpty(this.past);
    if (this.known === undefined || session === null) return html`${renderLoaded(this.table, msg("the topics"), () => nothing)}`;
    if (session.topics.length === 0) return this.renderEmpty();
    return html`<div class="view">
        <canvas tabindex="0" role="img" aria-label=${msg(str`The robot in space. Arrow keys move, plus and minus zoom. ${this.summary()}`)}
          @pointerdown=${this.onPointer} @pointermove=${this.onPointer} @pointerup=${this.onPointer} @keydown=${this.onKey}></canvas>
        ${this.drawing === null ? html`<div class="notes"><div class="note"><t-loading what=${msg("Loading the scene")}></t-loading></div></div>` : nothing}
        ${this.renderTools()}
        <div class="notes">${this.noSpace === "" ? nothing : html`<p class="note">${this.noSpace}</p>`}${this.renderNote()}</div>
        ${CORNERS}
      </div>
      ${this.bare ? nothing : this.renderSide(session.topics)}`;
  }

  /** What recordings hold of the moment; while nothing does, what was there stays listed. */
  private lookBack(past: PastBoard): void {
    const { moment } = past.topics;
    if (moment === null) return;
    const gone = moment.topics.length === 0;
    if (!gone) this.known = moment;
    if (gone && !this.unrecorded) this.session?.reset();
    this.unrecorded = gone;
  }

  /** Live pictures, or those of films. */
  private picturesOf(api: HubApi, past: PastBoard | null): OpenPictures {
    const { site, sockets } = this;
    if (past === null) return (listener) => new CameraPictures(site, listener, sockets);
    return (listener) => new FilmPictures({ site, past, lists: new FilmsApi(api), pictures: new FilmPicturesApi(api) }, listener);
  }

  private renderPastEmpty(past: PastBoard): TemplateResult {
    if (past.topics.moment === null) return html`<t-loading what=${msg("Looking for what was recorded")}></t-loading>`;
    const what = this.known === undefined ? msg("A recording of raw topics would hold the scene.") : msg("The recording holds no transforms, scans, maps or the like that you may see.");
    return html`<t-unrecorded .past=${past} zone=${this.zone} what=${what}></t-unrecorded>`;
  }

  private renderEmpty(): TemplateResult {
    return this.online
      ? html`<t-empty heading=${msg("Nothing to see in space")} icon="live">
          <p>${msg(html`The robot publishes no transforms, scans, maps or the like that you may follow. An admin opens topics in the site's description, under <code>topics:</code>, or gives you the right <strong>tap</strong>.`)}</p>
        </t-empty>`
      : html`<t-empty heading=${msg("The gateway is away")} icon="unlinked"><p>${msg("The scene appears by itself when the robot's gateway has connected.")}</p></t-empty>`;
  }

  private renderTools(): TemplateResult {
    const tools = [{ id: "measure", label: msg("Measure") }, ...this.poseTools];
    return html`<div class="tools" role="toolbar" aria-label=${msg("Scene")}>
      <t-button .pressed=${this.follow ? "true" : "false"} @click=${this.toggleFollow}>${msg("Follow")}</t-button>
      <t-button @click=${this.lookFromAbove}>${msg("From above")}</t-button>
      ${this.noSpace === "" ? html`<t-button @click=${this.lookAside}>${msg("In space")}</t-button>` : nothing}
      ${repeat(
        tools,
        ({ id }) => id,
        ({ id, label }) => html`<t-button data-tool=${id} .pressed=${this.tool === id ? "true" : "false"} @click=${this.onTool}>${label}</t-button>`,
      )}
    </div>`;
  }

  private renderNote(): TemplateResult | typeof nothing {
    const { preview, past } = this;
    if (past !== null && this.unrecorded) return html`<div class="note"><t-unrecorded .past=${past} zone=${this.zone}></t-unrecorded></div>`;
    if (!this.online && past === null) return html`<p class="note old" role="status">${msg("The robot's gateway is not connected: this is what came last.")}</p>`;
    if (preview !== null && "from" in preview) return html`<p class="note" role="status">${fixedText(lengthOf(preview), 2)} m</p>`;
    if (this.tool === "measure") return html`<p class="note">${msg("Drag from one place on the floor to another.")}</p>`;
    if (this.tool !== "") return html`<p class="note">${msg("Press where, and drag to where it is to look. It is sent only when you say so below.")}</p>`;
    const age = this.robotAge();
    if (age !== null && age > OLD_S) return html`<p class="note old" role="status">${msg(str`Where the robot is was said ${formatAge(age)}: it may be elsewhere.`)}</p>`;
    return this.trouble === "" ? nothing : html`<p class="note old" role="status">${this.trouble}</p>`;
  }

  private renderSide(topics: readonly SceneTopic[]): TemplateResult {
    const nowMs = this.session?.model.nowMs() ?? 0;
    const rows = this.session?.model.tree.rows(nowMs) ?? [];
    return html`<section class="side" aria-label=${msg("What is shown")} tabindex="0">
      <fieldset>
        <legend>${msg("Layers")}</legend>
        ${repeat(
          topics.filter(({ kind }) => isSwitched(kind)),
          ({ topic }) => topic,
          (topic) => this.renderTopic(topic, nowMs),
        )}
      </fieldset>
      <label class="field">${msg("Still stands")}<select @change=${this.chooseFixed}>
          <option value="" ?selected=${this.fixedChoice === ""}>${msg("by itself:")} ${this.fixedFrame() || msg("none yet")}</option>
          ${repeat(
            rows,
            ({ name }) => name,
            ({ name }) => html`<option value=${name} ?selected=${name === this.fixedChoice}>${name}</option>`,
          )}
        </select></label>
      <label class="field">${msg("Clouds by")}<select @change=${this.chooseCloud}>
          <option value="height" ?selected=${this.cloudBy === "height"}>${msg("height")}</option>
          <option value="intensity" ?selected=${this.cloudBy === "intensity"}>${msg("intensity")}</option>
          <option value="rgb" ?selected=${this.cloudBy === "rgb"}>${msg("their colours")}</option>
        </select></label>
      <label class="row"><input type="checkbox" .checked=${this.showFrames} @change=${this.toggleFrames} /><span>${msg("Axes of frames")}</span></label>
      <details>
        <summary>${msg(str`Frames (${String(rows.length)})`)}</summary>
        <ul class="frames">
          ${repeat(rows, ({ name }) => name, renderFrame)}
        </ul>
      </details>
    </section>`;
  }

  private renderTopic({ topic, kind, shown }: SceneTopic, nowMs: number): TemplateResult {
    const layer = this.session?.model.layers.get(topic);
    const latched = this.session?.stateOf(topic)?.update?.latched === true;
    const age = layer === undefined ? null : (nowMs - layer.heardMs) / 1000;
    const word = !shown || kind.kind === "robot" ? "" : age === null ? msg("waiting") : latched || age < OLD_S ? (this.past === null ? msg("live") : msg("recorded")) : formatAge(age);
    const lost = layer !== undefined && this.session?.model.placeOf(layer, this.fixedFrame()) === null;
    const problem = this.session?.problemOf(topic) ?? "";
    const why = !shown ? "" : problem !== "" ? problem : lost ? msg(str`No transform from ${layer.frame} to ${this.fixedFrame()}`) : "";
    const thinned = layer?.content.shape === "cloud" && layer.content.every > 1 ? msg(str`, 1 point of ${String(layer.content.every)}`) : "";
    return html`<label class="row">
      <input type="checkbox" .checked=${shown} data-topic=${topic} @change=${this.onLayer} />
      <span>${kind.name} <span class="topic">${topic}</span></span><span class="age">${word}${thinned}</span>
      ${why === "" ? nothing : html`<span class="why">${why}</span>`}
    </label>`;
  }

  private summary(): string {
    const shown = this.session?.topics.filter(({ shown: on, kind }) => on && isSwitched(kind)) ?? [];
    return msg(str`Shown: ${shown.map(({ kind }) => kind.name.toLowerCase()).join(", ") || msg("nothing")}.`);
  }

  private fixedFrame(): string {
    const tree = this.session?.model.tree;
    if (tree === undefined) return "";
    if (this.fixedChoice !== "" && tree.has(this.fixedChoice)) return this.fixedChoice;
    return chooseFixedFrame((name) => tree.has(name), tree.roots());
  }

  private robotFrame(): string {
    const tree = this.session?.model.tree;
    return tree === undefined ? "" : chooseRobotFrame((name) => tree.has(name), this.drawing?.modelFrame ?? "");
  }

  private robotAge(): number | null {
    const model = this.session?.model;
    return model === undefined ? null : model.tree.ageOf(this.robotFrame(), model.nowMs());
  }

  private async build(canvas: HTMLCanvasElement, session: SceneSession): Promise<void> {
    this.building = true;
    const colours = sceneColours(this);
    const report = (why: string): void => {
      this.trouble = why;
    };
    let drawing: SceneDrawing;
    try {
      // Large, and only for whoever looks at a scene.
      const { SceneView } = await import("./scene-view.js");
      drawing = new SceneView(canvas, session.model, this.site, colours, report);
    } catch {
      this.noSpace = msg("This browser cannot draw in space (it has no WebGL, or it is switched off): you see the scene from above.");
      const { FlatView } = await import("./flat-view.js");
      drawing = new FlatView(canvas, session.model, colours);
    }
    this.building = false;
    if (!this.isConnected || this.session !== session) {
      drawing.dispose();
      return;
    }
    this.drawing = drawing;
    this.sizes = new ResizeObserver(() => {
      drawing.resize(canvas.clientWidth, canvas.clientHeight, window.devicePixelRatio || 1);
    });
    this.sizes.observe(canvas);
    this.themes = new MutationObserver(this.recolour);
    this.themes.observe(document.documentElement, { attributeFilter: ["data-theme"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", this.recolour);
    this.requestUpdate();
  }

  private applyOptions(): void {
    this.drawing?.setOptions({
      fixed: this.fixedFrame(),
      follow: this.follow ? this.robotFrame() : "",
      cloudBy: this.cloudBy,
      showRobot: this.session?.topics.every(({ kind, shown }) => kind.kind !== "robot" || shown) ?? true,
      showFrames: this.showFrames,
    });
    this.drawing?.setTool(this.tool !== "");
  }

  private closeAll(): void {
    this.session?.close();
    this.session = null;
    this.drawing?.dispose();
    this.drawing = null;
    this.sizes?.disconnect();
    this.themes?.disconnect();
    matchMedia("(prefers-color-scheme: dark)").removeEventListener("change", this.recolour);
    this.chooseTool("");
  }

  /** Another press on the same ends it. */
  private chooseTool(id: string): void {
    this.tool = this.tool === id ? "" : id;
    this.showPreview(null);
    this.pointer =
      this.tool === ""
        ? null
        : new ScenePointer(this.tool === "measure" ? "measure" : "pose", this.fixedFrame(), this.showPreview, (pose) => {
            this.dispatchEvent(new CustomEvent<{ tool: string; pose: FloorPose }>("t-pose", { detail: { tool: this.tool, pose } }));
          });
  }

  private readonly showPreview = (preview: ScenePreview): void => {
    this.preview = preview;
    this.drawing?.setPreview(preview);
  };

  /** A jump ends all that was; a topic that begins anew ends its own. */
  private readonly onPastReset = (topic: string): void => {
    const { session, past } = this;
    if (session === null || past === null) return;
    if (past.jumps === this.resetJumps) {
      session.forget(topic);
    } else session.reset();
    this.resetJumps = past.jumps;
  };

  private readonly recolour = (): void => {
    this.drawing?.setColours(sceneColours(this));
  };

  private readonly onPointer = (event: PointerEvent): void => {
    if (this.pointer === null || this.drawing === null) return;
    if (event.type === "pointerdown") this.canvas?.setPointerCapture(event.pointerId);
    this.pointer.handle(event, this.drawing);
  };

  private readonly onKey = (event: KeyboardEvent): void => {
    if (event.key === "+" || event.key === "=") this.drawing?.zoom(1 / 1.15);
    else if (event.key === "-") this.drawing?.zoom(1.15);
    else if (event.key.startsWith("Arrow")) this.follow = false;
  };

  private readonly onTool = (event: Event): void => {
    this.chooseTool((event.currentTarget as HTMLElement).dataset["tool"] ?? "");
  };

  private readonly onLayer = (event: Event): void => {
    const box = event.target as HTMLInputElement;
    this.session?.show(box.dataset["topic"] ?? "", box.checked);
    this.requestUpdate();
  };

  private readonly toggleFollow = (): void => {
    this.follow = !this.follow;
  };

  private readonly lookFromAbove = (): void => {
    this.drawing?.lookFrom("above");
  };

  private readonly lookAside = (): void => {
    this.drawing?.lookFrom("aside");
  };

  private readonly toggleFrames = (): void => {
    this.showFrames = !this.showFrames;
  };

  private readonly chooseFixed = (event: Event): void => {
    this.fixedChoice = (event.target as HTMLSelectElement).value;
  };

  private readonly chooseCloud = (event: Event): void => {
    const { value } = event.target as HTMLSelectElement;
    this.cloudBy = value === "rgb" || value === "intensity" ? value : "height";
  };
}

function renderFrame({ name, depth, age, fixed }: FrameRow): TemplateResult {
  return html`<li>
    <span class="topic">${"\u2003".repeat(Math.min(depth, 8))}${name}</span>
    <span class=${!fixed && age !== null && age > OLD_S ? "old" : ""}>${fixed ? msg("fixed") : age === null ? msg("root") : formatAge(age)}</span>
  </li>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-scene": SceneElement;
  }
}
