"""The build sheet: instructions for building a map in wood, as PDF or CSV."""

from rsegen.exporters.cut_settings import CutSettings
from rsegen.exporters.sheet.document import SHEET_FORMATS, page_count, pages, refuse_unbuildable, sheet, sheet_format

__all__ = ["SHEET_FORMATS", "CutSettings", "page_count", "pages", "refuse_unbuildable", "sheet", "sheet_format"]
