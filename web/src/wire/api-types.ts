/** Shapes of the hub's HTTP interface, by the names the pages use; they are made from the hub's. */

export type {
  AnomalyList,
  AnomalyShape as AnomalyInfo,
  ArgumentShape as ArgumentInfo,
  CommandShape as CommandInfo,
  DeviceShape as DeviceInfo,
  DeviceSummary as DeviceRow,
  DriveShape as DriveInfo,
  EnclosurePartShape as PartInfo,
  EnclosureShape as EnclosureInfo,
  SightingShape as SightingInfo,
  EventList,
  EventShape as EventInfo,
  GapShape as HistoryGap,
  HistoryAnswer as History,
  LimitShape as LimitInfo,
  Me as Person,
  OutlierList,
  OutlierShape as OutlierInfo,
  PermissionShape as Permission,
  PlaceShape as PlaceInfo,
  PointingShape as PointingInfo,
  RuleShape as RuleInfo,
  SeriesShape as HistorySeries,
  SignalShape as SignalInfo,
  SiteShape as SiteDetail,
  SiteSummary as SiteRow,
  SkyList,
  SkyObject,
  StatisticsList,
  StatisticsShape as StatisticsInfo,
  StoredShape as StoredInfo,
  StreamShape as StreamInfo,
} from "../generated/api.js";

/** The roles that the hub is seeded with. An admin may add others, so a role is any text. */
export type Role = string;
export type Right = "view" | "use" | "admin";
