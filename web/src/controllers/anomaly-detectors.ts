/** Ties the anomaly detectors of a site to an element: asked for once, and then told. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { AnomalyDetectors } from "../state/anomaly-detectors.js";
import type { AnomalyList } from "../generated/api.js";
import { ConnectionStateController } from "./connection-state.js";
import { LoadController } from "./load.js";

/** What this needs of the hub's HTTP interface. */
export interface AnomalySource {
  anomalies(site: string): Promise<AnomalyList>;
}

export class AnomalyDetectorsController implements ReactiveController {
  book = new AnomalyDetectors();
  private readonly load: LoadController<AnomalyList>;
  private site = "";
  private taken: AnomalyList | undefined;

  constructor(host: ReactiveControllerHost & HTMLElement) {
    host.addController(this);
    this.load = new LoadController(host);
    new ConnectionStateController(host, (connection) => [
      connection.onMessage("anomaly", (news) => {
        if (news.site === this.site && this.book.applyUpdate(news)) host.requestUpdate();
      }),
      connection.onState((state) => {
        // What was told meanwhile was not heard.
        if (state === "open") this.retry();
      }),
    ]);
  }

  get state(): "idle" | "loading" | "ready" | "failed" {
    return this.load.result.state;
  }

  /** There is a list, though a newer one may be on its way. */
  get hasList(): boolean {
    return this.load.value !== undefined;
  }

  get renderError(): unknown {
    return this.load.result.state === "failed" ? this.load.result.error : null;
  }

  /** Call it from `willUpdate`. @param edition names the site's description: another one has other detectors */
  loadDetectors(api: AnomalySource, site: string, edition: string): void {
    if (site !== this.site) {
      this.site = site;
      this.book = new AnomalyDetectors();
      this.taken = undefined;
    }
    this.load.load(`${site} ${edition}`, () => {
      this.book.beginLoad();
      return api.anomalies(site);
    });
    const { result } = this.load;
    if (result.state !== "ready" || result.value === this.taken) return;
    this.taken = result.value;
    this.book.setList(result.value);
  }

  retry(): void {
    this.load.invalidate();
  }

  hostConnected(): void {
    this.taken = undefined;
  }
}
