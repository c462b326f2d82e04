/** How often the detectors of a site may cry, at the hub. */

import type { BudgetShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";

export class AlarmBudgetApi {
  constructor(
    private readonly api: HubApi,
    private readonly site: string,
  ) {}

  showBudget(): Promise<BudgetShape> {
    return this.api.request("GET", this.path());
  }

  /** Null: as the description says. */
  changeBudget(aWeek: number | null): Promise<BudgetShape> {
    return this.api.request("PUT", this.path(), { a_week: aWeek });
  }

  private path(): string {
    return `/api/sites/${encodeURIComponent(this.site)}/anomalies/budget`;
  }
}
