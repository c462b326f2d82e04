/** Shapes of the hub's HTTP interface, by the names the pages use; they are made from the hub's. */

import type { PermissionShape } from "../generated/api.js";

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

export type Right = PermissionShape["right"];
